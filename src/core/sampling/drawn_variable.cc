#include "sampling/drawn_variable.h"

#include <algorithm>
#include <cmath>

namespace granuscope {
namespace {

constexpr int halvings = 3;  // of an angle, to below pi / 16

/// The variable of a contact whose force leans by H over V: its angle from the vertical, or T/N.
double variable_of(DrawnVariable drawn, double leaning) {
  return drawn == DrawnVariable::angle ? portable_arctangent(leaning) : (sqrt3 * leaning - 1) / (leaning + sqrt3);
}

double leaning_of(DrawnVariable drawn, double variable) {
  return drawn == DrawnVariable::angle ? portable_tangent(variable) : (1 + sqrt3 * variable) / (sqrt3 - variable);
}

/// How fast the variable grows with the leaning.
double growth(DrawnVariable drawn, double leaning) {
  const double root = leaning + sqrt3;
  return drawn == DrawnVariable::angle ? 1 / (1 + leaning * leaning) : 4 / (root * root);
}

/// The horizontal force of a contact that carries V, its variable at fraction u of what the interval of that force
/// leaves.
double force_at(DrawnVariable drawn, double V, Interval force, double u) {
  if (!(V > 0)) return force.low;  // which is all of it
  const double low = variable_of(drawn, force.low / V), high = variable_of(drawn, force.high / V);
  return std::clamp(V * leaning_of(drawn, low + u * (high - low)), force.low, force.high);
}

/// The density of that force and the largest that it has.
struct ForceDensity {
  double here = 0, most = 0;
};
ForceDensity density_at(DrawnVariable drawn, double V, Interval force, double H) {
  const double low = force.low / V, high = force.high / V;
  const double per_force = 1 / (V * (variable_of(drawn, high) - variable_of(drawn, low)));
  const double steepest = drawn == DrawnVariable::angle ? std::clamp(0.0, low, high) : low;
  return {growth(drawn, H / V) * per_force, growth(drawn, steepest) * per_force};
}

}  // namespace

double split_at(DrawnVariable drawn, Outgoing out, double H, Interval interval, double uniform) {
  if (drawn == DrawnVariable::force || !(interval.low < interval.high)) return point_at(interval, uniform);
  // The left contact is the mirror image of a right one that carries H_R - H.
  const double split = uniform < 0.5
                           ? force_at(drawn, out.V_R, interval, 2 * uniform)
                           : H + force_at(drawn, out.V_L, {interval.low - H, interval.high - H}, 2 * uniform - 1);
  return std::clamp(split, interval.low, interval.high);
}

double kept_share(DrawnVariable drawn, Outgoing out, double H, Interval interval, double H_R) {
  if (drawn == DrawnVariable::force || !(interval.low < interval.high)) return 1;
  const ForceDensity right = density_at(drawn, out.V_R, interval, H_R);
  const ForceDensity left = density_at(drawn, out.V_L, {interval.low - H, interval.high - H}, H_R - H);
  const double share = (right.here + left.here) / (right.most + left.most);
  return std::isfinite(share) ? share : 1;  // an interval as narrow as rounding
}

double portable_arctangent(double x) {
  for (int k = 0; k < halvings; ++k) x /= 1 + std::sqrt(1 + x * x);
  const double square = x * x;  // below 0.04
  double series = 0;
  for (int power = 23; power >= 1; power -= 2) series = 1.0 / power - square * series;
  return (1 << halvings) * x * series;
}

double portable_tangent(double angle) {
  const double part = angle / (1 << halvings), square = part * part;
  double sine = 1, cosine = 1;  // their series, the former over the angle
  for (int k = 16; k >= 2; k -= 2) {
    sine = 1 - square * sine / (k * (k + 1));
    cosine = 1 - square * cosine / (k * (k - 1));
  }
  double tangent = part * sine / cosine;
  for (int k = 0; k < halvings; ++k) tangent = 2 * tangent / (1 - tangent * tangent);
  return tangent;
}

}  // namespace granuscope
