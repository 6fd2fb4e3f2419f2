#pragma once
#include <utility>

#include "model/pile_view.h"

namespace granuscope {

/// The layers of a pile, some at a time: of one in memory, or of one that is read where it is looked at, so that memory
/// need not hold more of it than a band of layers.
class PileLayers {
 public:
  PileLayers() = default;
  PileLayers(const PileLayers&) = delete;
  PileLayers& operator=(const PileLayers&) = delete;
  virtual ~PileLayers() = default;

  /// The pile without its forces; `range`: what hold() may be asked for.
  virtual const PileView& about() const = 0;
  /// A view that has the layers first .. last, both in the range, and perhaps more. Valid until the next call.
  virtual const PileView& hold(int first, int last) = 0;
  /// Wall time that hold() has taken so far to bring layers that were not there.
  virtual double seconds_reading() const { return 0; }
};

/// Those of a view, whose arrays must outlive this.
class LayersInMemory : public PileLayers {
 public:
  explicit LayersInMemory(PileView view) : view_(std::move(view)) {}
  const PileView& about() const override { return view_; }
  const PileView& hold(int, int) override { return view_; }

 private:
  PileView view_;
};

}  // namespace granuscope
