#include "report/touched_pile.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "plot/figure_captions.h"

namespace granuscope {
namespace {

constexpr std::size_t most_beads = 10'000;  ///< some 25 bytes each

}  // namespace

std::string touched_pile(const Pile& pile, const Pile* overloaded, const Pile* uniform, int layers) {
  const Lattice& lattice = pile.lattice;
  const std::size_t beads = lattice.index(layers - 1, lattice.columns() - 1) + 1;
  if (beads > most_beads || lattice.geometry().angle != usual_angle)
    return {};  // the page lays beads out at 30 degrees
  const auto thousandths = [](double value) { return std::llround(1000 * value); };
  const auto weight = [](const Pile& of, std::size_t i) { return of.V_R[i] + of.V_L[i]; };
  Json force = Json::array(), friction = Json::array(), weights = Json::array(), response = Json::array();
  for (std::size_t i = 0; i < beads; ++i) {
    for (const auto& [V, H] : {std::pair(pile.V_L[i], -pile.H_L[i]), {pile.V_R[i], pile.H_R[i]}}) {
      const double normal = 0.5 * (H + sqrt3 * V), tangential = 0.5 * std::abs(sqrt3 * H - V);
      force.push_back(thousandths(std::hypot(V, H)));
      friction.push_back(normal > 0 && pile.mu > 0 ? thousandths(tangential / (pile.mu * normal)) : 0);
    }
    weights.push_back(thousandths(weight(pile, i)));
    if (overloaded != nullptr) response.push_back(thousandths(weight(*overloaded, i) - weight(*uniform, i)));
  }
  return Json{{"columns", lattice.columns()}, {"layers", layers},  {"x0", lattice.x(0, 0)}, {"force", force},
              {"friction", friction},         {"weight", weights}, {"response", response}}
      .dump();
}

}  // namespace granuscope
