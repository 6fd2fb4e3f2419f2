#include "export/pile_export.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "export/network.h"
#include "export/vtu_file.h"
#include "support/files.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

void put(std::string& text, std::string_view word) { text += word; }

template <class Number>
requires std::integral<Number> || std::floating_point<Number>
void put(std::string& text, Number number) {
  if constexpr (std::floating_point<Number>) {
    if (!std::isfinite(number)) return put(text, std::string_view("NaN"));
  }
  std::array<char, 32> digits{};  // the shortest that reads back to the same double
  text.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), number).ptr);
}

/// A line of values with `between` between them.
template <class First, class... More>
void put_line(std::string& text, char between, const First& first, const More&... more) {
  put(text, first);
  ((text += between, put(text, more)), ...);
  text += '\n';
}

/// One text format and part: what stands before and behind, and a line or more for a bead and for a contact.
class TextFormat {
 public:
  virtual ~TextFormat() = default;
  virtual std::string begin(const PileView&) const { return ""; }
  virtual void add(std::string&, const PileView&, const NetworkBead&) const {}
  virtual void add(std::string&, const PileView&, const NetworkContact&) const {}
  virtual std::string end() const { return ""; }
  /// Contacts come behind all beads: the pile is gone through twice.
  virtual bool twice() const { return false; }
};

class CsvBeads : public TextFormat {
  std::string begin(const PileView&) const override {
    return CsvTable({"bead: dimensionless", "layer: dimensionless", "column: dimensionless", "x: bead diameters",
                     "z: bead diameters", "radius: bead diameters", "weight: loads of one top bead",
                     "residual: loads of one top bead"})
        .text();
  }
  void add(std::string& text, const PileView&, const NetworkBead& one) const override {
    put_line(text, ',', one.number, one.layer, one.column, one.x, one.z, bead_radius, one.weight, one.residual);
  }
};

class CsvContacts : public TextFormat {
  std::string begin(const PileView&) const override {
    return CsvTable({"upper: dimensionless", "lower: dimensionless", "across_seam: dimensionless",
                     "x_upper: bead diameters", "z_upper: bead diameters", "branch_x: bead diameters",
                     "branch_z: bead diameters", "N: loads of one top bead", "T: loads of one top bead",
                     "T_over_mu_N: dimensionless", "force_x: loads of one top bead", "force_z: loads of one top bead"})
        .text();
  }
  void add(std::string& text, const PileView&, const NetworkContact& one) const override {
    put_line(text, ',', one.upper, one.lower, int{one.across_seam}, one.x, one.z, one.branch_x, one.branch_z, one.N,
             one.T, one.share, one.H, one.V);
  }
};

/// The form of LAMMPS, doc of `dump` and its local style; OVITO reads it as such. Force: on the first bead, as
/// `compute pair/gran/local` of LIGGGHTS has it, whose flag tells of an image across the seam. Contacts with the floor
/// are in another file, of the columns of `compute wall/gran/local`: OVITO knows no end of a bond but a bead.
class Dump : public TextFormat {
 public:
  explicit Dump(NetworkPart part) : part_(part) {}
  std::string begin(const PileView& pile) const override {
    const Lattice& lattice = pile.lattice;
    const double half = lattice.half_width();
    const std::int64_t on_floor = contacts_on_floor(lattice);
    const auto head = [&](const char* kind, std::int64_t count, const char* columns) {
      return fmt::format(
          "ITEM: TIMESTEP\n0\nITEM: NUMBER OF {0}\n{1}\n"
          "ITEM: BOX BOUNDS pp ff pp\n{2} {3}\n{4} 0\n{5} {6}\nITEM: {0} {7}\n",
          kind, count, exact(-half), exact(half), exact(-lattice.z(lattice.layers() - 1) - bead_radius),
          exact(-bead_radius), exact(bead_radius), columns);
    };
    if (part_ == NetworkPart::beads) {
      return head("ATOMS", static_cast<std::int64_t>(lattice.beads()), "id type x y z radius weight residual");
    }
    if (part_ == NetworkPart::walls) {
      return head("ENTRIES", on_floor, "contact_x contact_y contact_z x1 y1 z1 mesh triangle id1 fx fy fz");
    }
    return head("ENTRIES", all_contacts(lattice) - on_floor, "x1 y1 z1 x2 y2 z2 id1 id2 periodic fx fy fz");
  }
  void add(std::string& text, const PileView&, const NetworkBead& one) const override {
    if (part_ != NetworkPart::beads) return;
    put_line(text, ' ', one.number + 1, 1, one.x, -one.z, 0, bead_radius, one.weight, one.residual);
  }
  void add(std::string& text, const PileView&, const NetworkContact& one) const override {
    const bool of_floor = one.lower == NetworkContact::floor;
    if (part_ == NetworkPart::walls && of_floor) {
      put_line(text, ' ', one.x + one.branch_x / 2, -one.z - one.branch_z / 2, 0, one.x, -one.z, 0, 0, 0, one.upper + 1,
               -one.H, one.V, 0);
    }
    if (part_ != NetworkPart::contacts || of_floor) return;
    put_line(text, ' ', one.x, -one.z, 0, one.x + one.branch_x, -one.z - one.branch_z, 0, one.upper + 1, one.lower + 1,
             int{one.across_seam}, -one.H, one.V, 0);
  }

 private:
  NetworkPart part_;
};

/// The tables that adjacencyMatrix.m (frame, bead, neighbour, tangential and normal force; -1 is a wall) and
/// particleTrack.m (frame, bead, x, y, radius, edge: -2 upper, 2 lower) of PeGS2 write. Each contact is there from
/// either side.
class Pegs : public TextFormat {
 public:
  explicit Pegs(NetworkPart part) : part_(part) {}
  void add(std::string& text, const PileView& pile, const NetworkBead& one) const override {
    if (part_ != NetworkPart::beads) return;
    const int edge = one.layer == 0 ? -2 : one.layer + 1 == pile.lattice.layers() ? 2 : 0;
    put_line(text, ',', frame, one.number + 1, one.x, one.z, bead_radius, edge);
  }
  void add(std::string& text, const PileView&, const NetworkContact& one) const override {
    if (part_ != NetworkPart::contacts) return;
    const bool wall = one.lower == NetworkContact::floor;
    put_line(text, ',', frame, one.upper + 1, wall ? -1 : one.lower + 1, one.T, one.N);
    if (!wall) put_line(text, ',', frame, one.lower + 1, one.upper + 1, one.T, one.N);
  }

 private:
  static constexpr int frame = 1;
  NetworkPart part_;
};

class GraphMl : public TextFormat {
 public:
  explicit GraphMl(std::string comment) : comment_(std::move(comment)) {}
  std::string begin(const PileView&) const override {
    std::string keys;
    for (std::size_t k = 0; k < of_node.size(); ++k) keys += key("node", of_node[k], k);
    for (std::size_t k = 0; k < of_edge.size(); ++k) keys += key("edge", of_edge[k], of_node.size() + k);
    return fmt::format(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}\n"
        "<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">\n{}<graph id=\"pile\" edgedefault=\"undirected\">\n",
        xml_comment(comment_), keys);
  }
  void add(std::string& text, const PileView&, const NetworkBead& one) const override {
    put(text, "<node id=\"");
    put(text, one.number);
    put(text, "\">");
    put_data(text, 0, one.layer, one.column, one.x, -one.z, bead_radius, one.weight, one.residual);
    put(text, "</node>\n");
  }
  void add(std::string& text, const PileView&, const NetworkContact& one) const override {
    if (one.lower == NetworkContact::floor) return;
    put(text, "<edge source=\"");
    put(text, one.upper);
    put(text, "\" target=\"");
    put(text, one.lower);
    put(text, "\">");
    put_data(text, of_node.size(), one.N, one.T, one.share, one.H, -one.V, one.branch_x, -one.branch_z,
             int{one.across_seam});
    put(text, "</edge>\n");
  }
  std::string end() const override { return "</graph>\n</graphml>\n"; }
  bool twice() const override { return true; }

 private:
  static constexpr std::array of_node{"layer", "column", "x", "y", "radius", "weight", "residual"};
  static constexpr std::array of_edge{"N",       "T",        "T_over_mu_N", "force_x",
                                      "force_y", "branch_x", "branch_y",    "across_seam"};

  static std::string key(const char* of, std::string_view name, std::size_t id) {
    const bool whole = name == "layer" || name == "column" || name == "across_seam";
    return fmt::format("<key id=\"d{}\" for=\"{}\" attr.name=\"{}\" attr.type=\"{}\"/>\n", id, of, name,
                       whole ? "int" : "double");
  }
  template <class... Values>
  static void put_data(std::string& text, std::size_t key, const Values&... values) {
    ((put(text, "<data key=\"d"), put(text, key++), put(text, "\">"), put(text, values), put(text, "</data>")), ...);
  }

  std::string comment_;
};

std::unique_ptr<TextFormat> text_format(PileFormat format, NetworkPart part, const std::string& comment) {
  const bool beads = part == NetworkPart::beads;
  if (format == PileFormat::dump_local) return std::make_unique<Dump>(part);
  if (format == PileFormat::pegs) return std::make_unique<Pegs>(part);
  if (format == PileFormat::graphml) return std::make_unique<GraphMl>(comment);
  if (beads) return std::make_unique<CsvBeads>();
  return std::make_unique<CsvContacts>();
}

void write_text(PileLayers& pile, const TextFormat& format, const std::filesystem::path& target, const Accept& accept) {
  const PileView about = pile.about();
  StreamedFile file(target);
  std::string text = format.begin(about);
  bool accepted = false;
  for (const bool second : {false, true}) {
    if (second && !format.twice()) break;
    for_each_piece(pile, [&](std::span<const NetworkBead> beads, std::span<const NetworkContact> contacts) {
      if (!second) {
        for (const NetworkBead& one : beads) format.add(text, about, one);
      }
      if (second || !format.twice()) {
        for (const NetworkContact& one : contacts) format.add(text, about, one);
      }
      if (!accepted) accept(text);
      accepted = true;
      file.append(text);
      text.clear();
    });
  }
  file.append(format.end());
  file.commit();
}

}  // namespace

bool has_part(PileFormat format, NetworkPart part) {
  return part == NetworkPart::walls ? format == PileFormat::dump_local
                                    : format != PileFormat::vtu && format != PileFormat::graphml;
}

std::string lost_in(const PileView& pile, const PileExport& what) {
  const Lattice& lattice = pile.lattice;
  const bool dump = what.format == PileFormat::dump_local, contacts = what.part == NetworkPart::contacts;
  if ((dump && contacts) || what.format == PileFormat::graphml) {
    return fmt::format("left out, since they push on the floor, which is no bead: {} of {} contacts{}",
                       contacts_on_floor(lattice), all_contacts(lattice),
                       dump ? "; --part walls writes them as LIGGGHTS does" : "; vtu and csv have them");
  }
  if (what.format == PileFormat::pegs && contacts && lattice.layers() > 1) {
    return fmt::format(
        "{} beads at either end of the ring, and PeGS knows no period: drawn between positions they "
        "cross all of it; granuscope contacts reads them with --period-x {}",
        how_many(contacts_across_seam(lattice), "contact joins", "contacts join"), exact(2 * lattice.half_width()));
  }
  return "";
}

void export_pile(PileLayers& pile, const PileExport& what, const std::filesystem::path& file, const Accept& accept) {
  const std::string comment =
      what.origin + "; lengths in bead diameters, y up, forces in loads of one top bead, pushed onto the lower bead";
  if (what.format == PileFormat::vtu) {
    accept("<?xml");
    return write_vtu(pile, file, comment);
  }
  write_text(pile, *text_format(what.format, what.part, comment), file, accept);
}

}  // namespace granuscope
