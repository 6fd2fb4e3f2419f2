#include "packing/packing_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <span>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

/// What a column may mean, with the names that say so; the first is the one that messages use.
struct Meaning {
  std::initializer_list<std::string_view> names;
  bool down = false;  ///< counted downwards: y is its negative
};

namespace meaning {
const Meaning first_id{{"id1", "upper", "i", "particle1", "first"}};
const Meaning second_id{{"id2", "lower", "j", "particle2", "second"}};
const Meaning first_point{{"point1"}}, second_point{{"point2"}};  // of VTK's lines
const Meaning x1{{"x1", "x_upper"}}, y1{{"y1"}}, down1{{"z_upper"}, true};
const Meaning x2{{"x2"}}, y2{{"y2"}};
const Meaning z1{{"z1"}}, z2{{"z2", "contact_z"}}, force_z{{"fz"}}, z{{"z"}};  // beside x and y: out of their plane
const Meaning contact_x{{"contact_x"}}, contact_y{{"contact_y"}};              // where a particle touches a wall
const Meaning branch_x{{"branch_x", "bx"}}, branch_y{{"branch_y", "by"}}, branch_down{{"branch_z"}, true};
const Meaning normal{{"n", "fn", "f_n", "normal", "normal_force", "fnormal", "forcen"}};
const Meaning tangential{{"t", "ft", "f_t", "tangential", "tangential_force", "shear", "absforcet"}};
const Meaning force_x{{"fx", "force_x"}}, force_y{{"fy", "force_y"}}, force_down{{"force_z"}, true};
const Meaning frame{{"frame", "step", "timestep"}};
const Meaning particle_id{{"id", "bead", "number", "particle", "node", "point"}};
const Meaning x{{"x"}}, y{{"y"}}, down{{"z"}, true};
const Meaning radius{{"radius", "r"}}, diameter{{"diameter", "d"}};
}  // namespace meaning

/// PeGS writes no header: adjacencyMatrix.m and particleTrack.m tell the order. Its y counts down, as in images.
const std::vector<std::string> pegs_contacts{"frame", "id1", "id2", "T", "N"};
const std::vector<std::string> pegs_particles{"frame", "id", "x", "y", "radius", "edge"};
const std::vector<std::string> pegs_particles_of_one_frame{"id", "x", "y", "radius", "edge"};

/// Programs print some six digits: what differs by less, in shares, is the same.
constexpr double rounded = 1e-4;
/// Out of the plane of x and y: a share of a branch, a force or the whole width.
constexpr double out_of_plane = 0.01;

constexpr std::size_t none = static_cast<std::size_t>(-1);
/// Sums of squares and cubes of what is larger would be no numbers.
bool is_number(double value) { return std::abs(value) < 1e100; }

/// A column of the table, and its sign.
struct Column {
  const NumberTable* table = nullptr;
  std::size_t at = none;
  double sign = 1;
  explicit operator bool() const { return at != none; }
  double operator()(std::size_t row) const { return sign * table->at(row, at); }
};

Column column_of(const NumberTable& table, std::initializer_list<const Meaning*> meanings) {
  for (const Meaning* meaning : meanings) {
    for (const std::string_view name : meaning->names) {
      const auto is_it = [&](const std::string& column) { return lower_case(column) == name; };
      const auto found = std::find_if(table.columns.begin(), table.columns.end(), is_it);
      if (found != table.columns.end() && std::find_if(found + 1, table.columns.end(), is_it) != table.columns.end()) {
        throw InputError("two columns are named {}, so that it is open which is meant; rename one", name);
      }
      if (found != table.columns.end()) {
        return {&table, static_cast<std::size_t>(found - table.columns.begin()), meaning->down ? -1.0 : 1.0};
      }
    }
  }
  return {};
}

std::string columns_in(const NumberTable& table, bool of_walls = false) {
  if (!table.named) return fmt::format("its {} no names", how_many(table.columns.size(), "column has", "columns have"));
  const bool computed = std::all_of(table.columns.begin(), table.columns.end(),
                                    [](const std::string& name) { return name.starts_with("c_"); });
  return fmt::format("its columns are {}{}", fmt::join(table.columns, ", "),
                     computed && table.columns.size() == 12
                         ? fmt::format(" (those of LIGGGHTS' `compute {}/gran/local pos id force` are {},fx,fy,fz)",
                                       of_walls ? "wall" : "pair",
                                       of_walls ? "contact_x,contact_y,contact_z,x1,y1,z1,mesh,triangle,id1"
                                                : "x1,y1,z1,x2,y2,z2,id1,id2,periodic")
                         : "");
}

/// What was taken for what in a file whose columns have no names.
void tell_of_usual_names(const NumberTable& table, const std::filesystem::path& file, Packing& packing) {
  if (!table.usual) return;
  packing.told.push_back(fmt::format("{} has no names of columns and is taken for a file of PeGS: {}; y counts down",
                                     file.filename().string(), fmt::join(table.columns, ",")));
}

/// The frames of a table that has several, ascending.
std::vector<double> frames_of(const NumberTable& table, const std::filesystem::path& file) {
  const Column frames = table.dump ? Column{} : column_of(table, {&meaning::frame});
  std::vector<double> seen;
  LineProblems problems(file, table.row_name);
  for (std::size_t row = 0; frames && row < table.rows(); ++row) {
    if (!is_number(frames(row))) problems.add(table.lines[row], "the frame is no number below 10^100");
    if (seen.empty() || seen.back() != frames(row)) seen.push_back(frames(row));
  }
  problems.raise();
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  return seen;
}

/// Keeps the rows of one frame of a table that has several; none where it lacks it and `needed` is false.
std::vector<std::size_t> rows_of_frame(const NumberTable& table, const std::filesystem::path& file,
                                       std::optional<double> wanted, bool needed) {
  std::vector<std::size_t> rows;
  rows.reserve(table.rows());
  const Column frames = table.dump ? Column{} : column_of(table, {&meaning::frame});
  const std::vector<double> seen = frames_of(table, file);
  if (needed && wanted && !table.dump && (!frames || !std::binary_search(seen.begin(), seen.end(), *wanted))) {
    throw InputError(frames ? fmt::format("{}: there is no frame {:g}; it has {:g} to {:g}", file.string(), *wanted,
                                          seen.front(), seen.back())
                            : fmt::format("{}: it has no column `frame`; leave out --step", file.string()));
  }
  for (std::size_t row = 0; row < table.rows(); ++row) {
    if (!frames || frames(row) == wanted.value_or(seen.back())) rows.push_back(row);
  }
  return rows;
}

class PackingReader {
 public:
  /// `particles`: null where the contacts say where they are; `walls`: null where none stand apart. `step` is the one
  /// of the contacts, if they have any.
  PackingReader(const PackingFiles& files, const NumberTable& contacts, const NumberTable* particles,
                const NumberTable* walls, std::optional<double> step)
      : files_(files), contacts_(contacts), particles_(particles), walls_(walls), step_(step) {}

  Packing read() {
    if (particles_ != nullptr) read_particles(*particles_);
    read_contacts(contacts_, files_.contacts);
    if (walls_ != nullptr) read_contacts(*walls_, files_.walls);
    set_mean_diameter();
    for (const std::optional<double>& period : periods_) {
      if (packing_.sized && period && !(*period >= packing_.mean_diameter)) {
        throw InputError("{}: the box has a period of {:g}, which is less than a particle of {:g} across",
                         files_.contacts.string(), *period, packing_.mean_diameter);
      }
    }
    tell_of_long_branches();
    return std::move(packing_);
  }

 private:
  void read_particles(const NumberTable& table) {
    tell_of_usual_names(table, files_.particles, packing_);
    const bool upside_down = table.usual;
    const Column ids = column_of(table, {&meaning::particle_id}), xs = column_of(table, {&meaning::x}),
                 ys = column_of(table, {&meaning::y, &meaning::down});
    const Column radii = column_of(table, {&meaning::radius}), diameters = column_of(table, {&meaning::diameter});
    if (!ids || !xs || !ys) {
      throw InputError("{}: {}, and id, x and y are needed; name them by --particle-columns", files_.particles.string(),
                       columns_in(table));
    }
    if (const Column zs = ys.sign > 0 ? column_of(table, {&meaning::z}) : Column{}) {
      const auto width_of = [&](const Column& column) {
        double least = column(0), most = least;
        for (std::size_t row = 1; row < table.rows(); ++row) {
          least = std::min(least, column(row));
          most = std::max(most, column(row));
        }
        return most - least;
      };
      if (width_of(zs) > out_of_plane * width_of(xs)) {
        throw InputError(
            "{}: its particles lie at different z, and packings here are two-dimensional; give --particle-columns y=z "
            "for the plane of x and z, or old=z to leave z out",
            files_.particles.string());
      }
    }
    periods_ = table.periods;
    LineProblems problems(files_.particles.empty() ? files_.contacts : files_.particles, table.row_name);
    // Particles that stay in place are told once, for all steps.
    const bool framed = static_cast<bool>(column_of(table, {&meaning::frame}));
    for (const std::size_t row : rows_of_frame(table, files_.particles, step_, framed)) {
      Particle one;
      one.x = xs(row);
      one.y = upside_down ? -ys(row) : ys(row);
      one.radius = radii ? radii(row) : diameters ? diameters(row) / 2 : 0;
      const double id = ids(row);
      if (!is_number(one.x) || !is_number(one.y) || !(one.radius >= 0) || !is_number(one.radius)) {
        problems.add(table.lines[row], "x, y or the radius is no number, or the radius is negative");
      } else if (!is_id(id)) {
        problems.add(table.lines[row], fmt::format("the id {:g} is no whole number from 0 to 10^15", id));
      } else {
        one.id = static_cast<std::int64_t>(id);
        if (!places_.emplace(one.id, packing_.particles.size()).second) {
          problems.add(table.lines[row], fmt::format("the particle {} stands twice", one.id));
        }
        packing_.particles.push_back(one);
      }
    }
    problems.raise();
  }

  static bool is_id(double number) { return number >= 0 && number < 1e15 && number == std::floor(number); }

  /// The place of a particle; a new one where contacts say where it is.
  std::size_t place_of(std::int64_t id, bool placed, double at_x, double at_y) {
    const auto found = places_.find(id);
    if (found != places_.end()) return found->second;
    if (particles_ != nullptr) return PackingContact::wall;
    places_.emplace(id, packing_.particles.size());
    packing_.particles.push_back({id, placed ? at_x : std::nan(""), placed ? at_y : std::nan(""), 0});
    return packing_.particles.size() - 1;
  }

  /// The shortest of the images of a branch.
  double nearest(double length, std::size_t axis) const {
    return periods_[axis] ? length - *periods_[axis] * std::round(length / *periods_[axis]) : length;
  }

  struct Columns {
    Column id1, id2, x1, y1, x2, y2, branch_x, branch_y, N, T, fx, fy, z1, z2, fz, contact_x, contact_y;
    bool placed() const { return x1 && y1 && ((x2 && y2) || (branch_x && branch_y)); }
    bool touching() const { return id1 && contact_x && contact_y; }  ///< walls, at a known place
    bool forces() const { return fx && fy; }
  };

  Columns columns_of(const NumberTable& table, const std::filesystem::path& file) const {
    Columns c{column_of(table, {&meaning::first_id}), column_of(table, {&meaning::second_id}),
              column_of(table, {&meaning::x1}),       column_of(table, {&meaning::y1, &meaning::down1}),
              column_of(table, {&meaning::x2}),       column_of(table, {&meaning::y2}),
              column_of(table, {&meaning::branch_x}), column_of(table, {&meaning::branch_y, &meaning::branch_down}),
              column_of(table, {&meaning::normal}),   column_of(table, {&meaning::tangential}),
              column_of(table, {&meaning::force_x}),  column_of(table, {&meaning::force_y, &meaning::force_down}),
              column_of(table, {&meaning::z1}),       column_of(table, {&meaning::z2}),
              column_of(table, {&meaning::force_z}),  column_of(table, {&meaning::contact_x}),
              column_of(table, {&meaning::contact_y})};
    // Points of VTK's lines are its particles, unless others say what the particles are.
    if (!(c.id1 && c.id2) && !c.touching() && particles_ == nullptr) {
      c.id1 = column_of(table, {&meaning::first_point});
      c.id2 = column_of(table, {&meaning::second_point});
    }
    const bool ids = c.id1 && (c.id2 || c.touching());
    const bool forces = c.N || (c.forces() && (c.placed() || (c.touching() && c.x1 && c.y1) || particles_ != nullptr));
    if (!forces || (!ids && !c.placed())) {
      const bool of_walls = &table == walls_;
      throw InputError("{}: {}; needed are {}; name them by {}, known are {}", file.string(),
                       columns_in(table, of_walls),
                       !forces ? "the normal force N (and T), or fx and fy with places"
                               : "id1 and id2, or x1, y1, x2 and y2, or of walls id1, contact_x and contact_y",
                       of_walls ? "--wall-columns" : "--columns", known_contact_columns());
    }
    return c;
  }

  void read_contacts(const NumberTable& table, const std::filesystem::path& file) {
    tell_of_usual_names(table, file, packing_);
    for (const std::size_t axis : {0, 1}) {
      if (table.periods[axis]) periods_[axis] = table.periods[axis];
      if (files_.periods[axis]) periods_[axis] = files_.periods[axis];
    }
    const Columns c = columns_of(table, file);
    if (c.branch_x && !c.placed() && particles_ == nullptr) {
      packing_.told.emplace_back("branches without x1 and y1 are left alone; --particles says where they begin");
    }
    const bool tangential = c.T || (c.forces() && !c.N), first_file = packing_.contacts.empty();
    packing_.tangential = tangential && (first_file || packing_.tangential);
    LineProblems problems(file, table.row_name);
    std::unordered_map<std::uint64_t, std::size_t> seen;
    seen.reserve(table.rows());
    std::unordered_set<std::size_t> twins;
    std::vector<double> apart;
    std::vector<std::size_t> lines(packing_.contacts.size());
    const std::size_t before_it = lines.size();
    packing_.contacts.reserve(before_it + table.rows());
    lines.reserve(before_it + table.rows());
    for (const std::size_t row : rows_of_frame(table, file, step_, first_file)) {
      const auto none_in = [&](const Column* column) { return !*column || (*column)(row) == 0; };
      // LAMMPS lists every particle, with zeros where it touches no wall.
      const std::array told{&c.N, &c.fx, &c.fy, &c.contact_x, &c.contact_y};
      if (c.touching() && !c.id2 && std::ranges::all_of(told, none_in)) continue;
      PackingContact one;
      std::string wrong = contact_in(c, row, one);
      if (wrong.empty() && !first_file && (one.first == PackingContact::wall || one.second != PackingContact::wall)) {
        wrong = "a contact of two particles, or of unnamed ones; those of --walls are of one particle and a wall";
      }
      if (!wrong.empty()) {
        problems.add(table.lines[row], wrong);
        continue;
      }
      if (c.id1 && c.id2 && one.first != PackingContact::wall && one.second != PackingContact::wall) {
        const auto [low, high] = std::minmax(one.first, one.second);
        const auto [at, is_new] = seen.emplace((std::uint64_t{high} << 32U) ^ low, packing_.contacts.size());
        if (!is_new) {
          PackingContact& before = packing_.contacts[at->second];
          const bool turned = before.first == one.second;
          const double side = turned ? -1 : 1;
          const double near = rounded * std::hypot(before.branch_x, before.branch_y);
          const bool same_place = !one.placed || (std::abs(one.branch_x - side * before.branch_x) <= near &&
                                                  std::abs(one.branch_y - side * before.branch_y) <= near);
          if (same_place && (!turned || !twins.insert(at->second).second)) {
            problems.add(table.lines[row],
                         fmt::format("the contact of {} and {} stands in {} {}, too", packing_.particles[one.first].id,
                                     packing_.particles[one.second].id, table.row_name, lines[at->second]));
          } else if (same_place) {
            apart.push_back(join(before, one));
          }
          if (same_place) continue;
        }
      }
      packing_.contacts.push_back(one);
      lines.push_back(table.lines[row]);
    }
    problems.raise();
    if (packing_.contacts.empty()) throw InputError("{}: there is no contact in it", file.string());
    point_away(before_it, file);
    if (!first_file) return;
    packing_.twins = apart.size();
    if (apart.empty()) return;
    std::nth_element(apart.begin(), apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2), apart.end());
    const double median = apart[apart.size() / 2];
    packing_.told.push_back(fmt::format("{} again from the other side and counted once{}",
                                        how_many(apart.size(), "contact is told", "contacts are told"),
                                        median > 0 ? fmt::format(", by the mean of both sides, whose forces "
                                                                 "differ by {:.2g} % in the median",
                                                                 100 * median)
                                                   : ""));
  }

  /// Programs that measure each particle by itself tell two forces of a contact: their mean is taken, with the sign of
  /// T as the first side has it, since not all turn it alike. How far the two differ, as a share of their mean.
  static double join(PackingContact& one, const PackingContact& again) {
    const double T = std::copysign(again.T, one.T);
    const double apart = std::hypot(one.N - again.N, one.T - T), mean = std::hypot(one.N + again.N, one.T + T) / 2;
    if (apart <= rounded * mean) return 0;
    one.N = (one.N + again.N) / 2;
    one.T = (one.T + T) / 2;
    return apart / mean;
  }

  /// Fills a contact; what is wrong with it, or nothing.
  std::string contact_in(const Columns& c, std::size_t row, PackingContact& one) {
    std::int64_t ids[2] = {-1, -1};
    for (const std::size_t k : {0, 1}) {
      const Column& column = k == 0 ? c.id1 : c.id2;
      if (!column) continue;
      const double id = column(row);
      if (!is_id(std::abs(id))) return fmt::format("the id {:g} of a particle is no whole number up to 10^15", id);
      ids[k] = static_cast<std::int64_t>(id);
    }
    for (const Column* column :
         {&c.x1, &c.y1, &c.x2, &c.y2, &c.branch_x, &c.branch_y, &c.N, &c.T, &c.fx, &c.fy, &c.contact_x, &c.contact_y}) {
      if (*column && !is_number((*column)(row))) {
        return fmt::format("{} is no number below 10^100", column->table->columns[column->at]);
      }
    }
    if (c.id1 && ids[0] < 0) return "the first particle is a wall; a wall, of a negative id, stands second";
    if (c.id1 && ids[0] == ids[1]) return fmt::format("the particle {} touches itself", ids[0]);
    one.placed = c.placed();
    if (one.placed) {
      one.x = c.x1(row);
      one.y = c.y1(row);
      one.branch_x = c.branch_x ? c.branch_x(row) : nearest(c.x2(row) - one.x, 0);
      one.branch_y = c.branch_y ? c.branch_y(row) : nearest(c.y2(row) - one.y, 1);
    }
    if (c.id1) {
      one.first = place_of(ids[0], one.placed, one.x, one.y);
      if (one.first == PackingContact::wall) return fmt::format("there is no particle {}", ids[0]);
      if (ids[1] >= 0) {
        one.second = place_of(ids[1], one.placed, c.x2 ? c.x2(row) : one.x + one.branch_x,
                              c.y2 ? c.y2(row) : one.y + one.branch_y);
        if (one.second == PackingContact::wall) return fmt::format("there is no particle {}", ids[1]);
      }
    }
    if (c.touching() && ids[1] < 0 && ((c.x1 && c.y1) || particles_ != nullptr)) {
      one.placed = true;
      one.x = c.x1 && c.y1 ? c.x1(row) : packing_.particles[one.first].x;
      one.y = c.x1 && c.y1 ? c.y1(row) : packing_.particles[one.first].y;
      one.branch_x = 2 * nearest(c.contact_x(row) - one.x, 0);  // as far beyond the wall as the particle is before it
      one.branch_y = 2 * nearest(c.contact_y(row) - one.y, 1);
    }
    if (!one.placed && particles_ != nullptr && one.second != PackingContact::wall) {
      const Particle &a = packing_.particles[one.first], &b = packing_.particles[one.second];
      one.placed = true;
      one.x = a.x;
      one.y = a.y;
      one.branch_x = c.branch_x ? c.branch_x(row) : nearest(b.x - a.x, 0);
      one.branch_y = c.branch_y ? c.branch_y(row) : nearest(b.y - a.y, 1);
    }
    const double length = std::hypot(one.branch_x, one.branch_y);
    if ((c.z1 && c.z2 && std::abs(c.z2(row) - c.z1(row)) > out_of_plane * length) ||
        (c.fz && c.forces() && std::abs(c.fz(row)) > out_of_plane * std::hypot(c.fx(row), c.fy(row)))) {
      return "it reaches out of the plane of x and y (z1, z2 or fz), and packings here are two-dimensional; give "
             "--columns y1=z1,y2=z2,fy=fz for the plane of x and z, or old1=z1,old2=z2,old3=fz to leave z out";
    }
    if (one.placed && length == 0) return "both particles are at one place, so that the contact has no direction";
    if (c.N) {
      one.N = c.N(row);
      one.T = c.T ? c.T(row) : 0;
      // Signs are those of either particle; of a force without a column for T no more than its size is known.
      if (const double force = std::hypot(one.N, one.T); c.forces()) {
        const double told = std::hypot(c.fx(row), c.fy(row));
        if (force > told * (1 + rounded) || (c.T && force < told * (1 - rounded))) {
          return fmt::format("N and T make a force of {:g}, fx and fy one of {:g}; leave out two of these columns",
                             force, told);
        }
      }
    } else if (!one.placed) {
      return "a wall without a place, whose force has no normal part then; give N and T";
    } else {
      const double fx = c.fx(row), fy = c.fy(row);
      one.N = (fx * one.branch_x + fy * one.branch_y) / length;
      one.T = (fy * one.branch_x - fx * one.branch_y) / length;
    }
    return "";
  }

  /// Programs write the force on either particle. Most contacts are compressed, which tells it.
  void point_away(std::size_t from, const std::filesystem::path& file) {
    const std::span<PackingContact> contacts = std::span(packing_.contacts).subspan(from);
    double sum = 0;
    for (const PackingContact& one : contacts) sum += one.N;
    if (sum >= 0) return;
    for (PackingContact& one : contacts) {
      one.N = -one.N;
      one.T = -one.T;
    }
    packing_.told.push_back(file.filename().string() +
                            " has forces on the first particle, or tension above 0: signs are turned");
  }

  void set_mean_diameter() {
    double sum = 0;
    std::size_t known = 0;
    for (const Particle& one : packing_.particles) {
      sum += 2 * one.radius;
      known += one.radius > 0 ? 1 : 0;
    }
    std::vector<double> lengths;
    for (const PackingContact& one : packing_.contacts) {
      const bool of_wall = one.second == PackingContact::wall && one.first != PackingContact::wall;
      if (one.placed && !of_wall) lengths.push_back(std::hypot(one.branch_x, one.branch_y));
    }
    const std::size_t count = lengths.size();
    const auto upper = lengths.begin() + static_cast<std::ptrdiff_t>(count / 2);
    if (count > 0) std::nth_element(lengths.begin(), upper, lengths.end());
    packing_.sized = known > 0 || count > 0;
    if (known > 0) {
      packing_.mean_diameter = sum / static_cast<double>(known);
    } else if (count > 0) {
      packing_.mean_diameter = count % 2 == 1 ? *upper : (*std::max_element(lengths.begin(), upper) + *upper) / 2;
    }
  }

  /// Across a periodic box of which the files do not tell, contacts look as long as the box.
  void tell_of_long_branches() {
    std::size_t count = 0;
    for (const PackingContact& one : packing_.contacts) {
      if (!one.placed) continue;
      const auto radius = [&](std::size_t at) {
        return at == PackingContact::wall ? 0 : packing_.particles[at].radius;
      };
      const double touching = radius(one.first) + radius(one.second);
      const double longest =
          touching > 0 && one.second != PackingContact::wall ? 1.5 * touching : 3 * packing_.mean_diameter;
      count += std::hypot(one.branch_x, one.branch_y) > longest ? 1 : 0;
    }
    if (count == 0) return;
    packing_.told.push_back(fmt::format(
        "{} far longer than particles, and counted so; if the box is periodic give --period-x or --period-y",
        how_many(count, "contact is", "contacts are")));
  }

  const PackingFiles& files_;
  const NumberTable& contacts_;
  const NumberTable *particles_, *walls_;
  std::optional<double> step_;
  Packing packing_;
  std::unordered_map<std::int64_t, std::size_t> places_;
  std::array<std::optional<double>, 2> periods_{};
};

}  // namespace

std::string known_contact_columns() {
  return "id1, id2, x1, y1, x2, y2, branch_x, branch_y, N, T, fx, fy, frame, and of walls contact_x, contact_y";
}
std::string known_particle_columns() { return "id, x, y, radius, diameter, frame"; }

PackingSource::PackingSource(PackingFiles files)
    : files_(std::move(files)), contacts_(files_.contacts, {files_.columns, {pegs_contacts}}, TableOf::contacts) {
  if (!files_.walls.empty()) walls_.emplace(files_.walls, ColumnNames{files_.wall_columns, {}}, TableOf::contacts);
  if (!files_.particles.empty()) {
    particles_.emplace(files_.particles,
                       ColumnNames{files_.particle_columns, {pegs_particles, pegs_particles_of_one_frame}},
                       TableOf::particles);
  } else if (contacts_.steps().empty() && contacts_.read({})->row_name == "cell") {
    NumberFile points(files_.contacts, {files_.particle_columns, {}}, TableOf::particles);
    if (column_of(*points.read({}), {&meaning::radius, &meaning::diameter})) particles_.emplace(std::move(points));
  }
}

std::vector<double> PackingSource::steps() const {
  std::vector<double> steps = contacts_.steps();
  return steps.empty() ? frames_of(*contacts_.read({}), files_.contacts) : steps;
}

Packing PackingSource::read(std::optional<double> step) const {
  const auto contacts = contacts_.read(step);
  const std::vector<double> frames = frames_of(*contacts, files_.contacts);
  if (contacts->dump) step = contacts->step;
  if (!step && !frames.empty()) step = frames.back();
  const auto particles = particles_ ? particles_->read(step) : nullptr,
             walls = walls_ ? walls_->read(step, true) : nullptr;
  Packing packing = PackingReader(files_, *contacts, particles.get(), walls.get(), step).read();
  packing.step = step;
  packing.steps = frames.empty() ? contacts->steps : frames.size();
  return packing;
}

}  // namespace granuscope
