// Source: what is written must be read again; files of beads must not change.
#include <catch2/catch.hpp>

#include "kit/temporary_folder.h"
#include "storage/ensemble_file.h"
#include "storage/sample_records.h"
#include "support/files.h"

using namespace granuscope;

TEST_CASE("where the rows of a model lie is stored with its sums, and goes without saying for beads") {
  const test::TemporaryFolder folder;
  EnsembleRecord record = test::awkward_ensemble();
  write_ensemble(folder.path() / "beads.h5", record);
  CHECK(read_ensemble(folder.path() / "beads.h5").sums.rows == RowGeometry{});
  CHECK(read_file(folder.path() / "beads.h5").find("row_spacing") == std::string::npos);
  record.sums.rows = {.spacing = sqrt3, .staggered = false};
  write_ensemble(folder.path() / "legs.h5", record);
  CHECK(read_ensemble(folder.path() / "legs.h5").sums.rows == record.sums.rows);
}
