#include "export/vtu_file.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "export/network.h"
#include "export/vtk_file.h"

namespace granuscope {
namespace {

constexpr std::uint8_t vertex = 1, segment = 3;  // VTK_VERTEX, VTK_LINE
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Of each point; the ends of lines that are no beads follow the beads: `of_end`.
struct BeadColumn {
  const char* name;
  double (*of_bead)(const NetworkBead&);
  double of_end;
};
constexpr std::array<BeadColumn, 3> bead_columns = {
    {{"radius", [](const NetworkBead&) { return bead_radius; }, 0},
     {"weight", [](const NetworkBead& bead) { return bead.weight; }, unknown},
     {"residual", [](const NetworkBead& bead) { return bead.residual; }, unknown}}};

/// Of each cell; those of the beads come before those of the contacts and have no value. From which of numbers_of() on.
struct ContactColumn {
  const char* name;
  std::size_t components, from;
};
constexpr std::array<ContactColumn, 5> contact_columns = {
    {{"N", 1, 0}, {"T", 1, 1}, {"T_over_mu_N", 1, 2}, {"force", 3, 3}, {"branch", 3, 6}}};
std::array<double, 9> numbers_of(const NetworkContact& one) {
  return {one.N, one.T, one.share, one.H, -one.V, 0, one.branch_x, -one.branch_z, 0};
}

constexpr std::array<const char*, 3> id_columns = {"upper", "lower", "across_seam"};
std::array<std::int64_t, 3> ids_of(const NetworkContact& one) { return {one.upper, one.lower, one.across_seam}; }

/// Puts arrays in the order in which they were declared.
class Putter {
 public:
  explicit Putter(VtkFile& file) : file_(file) {}

  /// `make` appends the numbers of one item.
  template <class Number, class Item, class Make>
  void put(std::uint64_t first, std::span<const Item> items, const Make& make) {
    std::vector<Number> numbers;
    for (const Item& item : items) make(item, numbers);
    file_.put(array_++, first, std::span<const Number>(numbers));
  }

 private:
  VtkFile& file_;
  std::size_t array_ = 0;
};

}  // namespace

void write_vtu(PileLayers& pile, const std::filesystem::path& file, const std::string& comment) {
  const Lattice lattice = pile.about().lattice;
  const auto beads = static_cast<std::uint64_t>(lattice.beads());
  const auto contacts = static_cast<std::uint64_t>(all_contacts(lattice));
  // A line across the seam ends at an image of its bead, half a bead past the ring's end.
  const auto seam_ends = static_cast<std::uint64_t>(contacts_across_seam(lattice));
  const std::uint64_t points = beads + seam_ends + static_cast<std::uint64_t>(contacts_on_floor(lattice));
  const std::uint64_t cells = beads + contacts;

  VtkFile vtk(file, "UnstructuredGrid");
  std::string inside =
      fmt::format("<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n", points, cells);
  inside += vtk.array("Points", "Float64", 3, points) + "</Points>\n<PointData>\n";
  inside += vtk.array("bead", "Int64", 1, points);
  for (const BeadColumn& column : bead_columns) inside += vtk.array(column.name, "Float64", 1, points);
  inside += "</PointData>\n<CellData Scalars=\"N\">\n";
  for (const ContactColumn& column : contact_columns) {
    inside += vtk.array(column.name, "Float64", column.components, cells);
  }
  for (const char* name : id_columns) inside += vtk.array(name, "Int64", 1, cells);
  inside += "</CellData>\n<Cells>\n" + vtk.array("connectivity", "Int64", 1, beads + 2 * contacts);
  inside += vtk.array("offsets", "Int64", 1, cells);
  inside += vtk.array("types", "UInt8", 1, cells) + "</Cells>\n</Piece>\n</UnstructuredGrid>\n";
  vtk.begin(comment, inside);

  std::uint64_t next_end = beads;
  for_each_piece(pile, [&](std::span<const NetworkBead> some, std::span<const NetworkContact> below) {
    const auto first = static_cast<std::uint64_t>(some.front().number);
    const std::uint64_t first_line = beads + 2 * first;
    std::vector<const NetworkContact*> ends;  // contacts whose line ends at no bead
    std::vector<std::int64_t> far;            // the point where each line ends
    for (const NetworkContact& one : below) {
      const bool at_bead = one.lower != NetworkContact::floor && !one.across_seam;
      far.push_back(at_bead ? one.lower : static_cast<std::int64_t>(next_end + ends.size()));
      if (!at_bead) ends.push_back(&one);
    }
    const std::span<const NetworkContact* const> all_ends(ends);

    Putter beads_of(vtk), ends_of(vtk);
    beads_of.put<double>(first, some, [](const NetworkBead& one, auto& to) {
      to.insert(to.end(), {one.x, -one.z, 0});
    });
    ends_of.put<double>(next_end, all_ends, [](const NetworkContact* one, auto& to) {
      to.insert(to.end(), {one->x + one->branch_x, -one->z - one->branch_z, 0});
    });
    beads_of.put<std::int64_t>(first, some, [](const NetworkBead& one, auto& to) { to.push_back(one.number); });
    ends_of.put<std::int64_t>(next_end, all_ends,
                              [](const NetworkContact* one, auto& to) { to.push_back(one->lower); });
    for (const BeadColumn& column : bead_columns) {
      beads_of.put<double>(first, some, [&](const NetworkBead& one, auto& to) { to.push_back(column.of_bead(one)); });
      ends_of.put<double>(next_end, all_ends, [&](const NetworkContact*, auto& to) { to.push_back(column.of_end); });
    }
    next_end += ends.size();

    Putter points_of = beads_of, lines_of = beads_of;  // the same arrays, which are those of cells
    for (const ContactColumn& column : contact_columns) {
      points_of.put<double>(first, some,
                            [&](const NetworkBead&, auto& to) { to.insert(to.end(), column.components, unknown); });
      lines_of.put<double>(first_line, below, [&](const NetworkContact& one, auto& to) {
        const std::array<double, 9> numbers = numbers_of(one);
        to.insert(to.end(), &numbers[column.from], &numbers[column.from] + column.components);
      });
    }
    for (std::size_t id = 0; id < id_columns.size(); ++id) {
      points_of.put<std::int64_t>(first, some, [](const NetworkBead&, auto& to) { to.push_back(-1); });
      lines_of.put<std::int64_t>(first_line, below,
                                 [&](const NetworkContact& one, auto& to) { to.push_back(ids_of(one)[id]); });
    }
    points_of.put<std::int64_t>(first, some, [](const NetworkBead& one, auto& to) { to.push_back(one.number); });
    std::size_t line = 0;
    lines_of.put<std::int64_t>(beads + 4 * first, below, [&](const NetworkContact& one, auto& to) {
      to.insert(to.end(), {one.upper, far[line++]});
    });
    points_of.put<std::int64_t>(first, some, [](const NetworkBead& one, auto& to) { to.push_back(one.number + 1); });
    auto end_of_line = static_cast<std::int64_t>(beads + 4 * first);
    lines_of.put<std::int64_t>(first_line, below,
                               [&](const NetworkContact&, auto& to) { to.push_back(end_of_line += 2); });
    points_of.put<std::uint8_t>(first, some, [](const NetworkBead&, auto& to) { to.push_back(vertex); });
    lines_of.put<std::uint8_t>(first_line, below, [](const NetworkContact&, auto& to) { to.push_back(segment); });
  });
  vtk.commit();
}

}  // namespace granuscope
