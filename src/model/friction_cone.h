#pragma once

namespace granuscope {

/// Coulomb's cone of half angle atan(mu) around a contact 30° from the vertical, in (V, H) of that contact:
///   t_minus V_R <= H_R <= t_plus V_R,   t_minus V_L <= -H_L <= t_plus V_L.
/// t_minus = tan(30° - atan mu), t_plus = tan(30° + atan mu).
class FrictionCone {
 public:
  /// Throws InputError unless 0 <= mu < sqrt(3) (at sqrt(3) the cone reaches the horizontal).
  explicit FrictionCone(double mu);
  double mu() const { return mu_; }
  double t_minus() const { return t_minus_; }
  double t_plus() const { return t_plus_; }
  /// k = sqrt(3) (t_minus + t_plus) - 1 > 0, the slope that enters the band of solvable H.
  double k() const { return k_; }
  double t_minus_over_k() const { return t_minus_over_k_; }
  double t_plus_over_k() const { return t_plus_over_k_; }

 private:
  double mu_, t_minus_, t_plus_, k_, t_minus_over_k_, t_plus_over_k_;
};

}  // namespace granuscope
