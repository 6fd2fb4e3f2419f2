#pragma once
#include <memory>

#include "render/gl_context.h"
#include "render/sample_grid.h"
#include "render/scene.h"

namespace granuscope {
/// How to paint; nothing here changes a pixel.
struct PaintOptions {
  /// Largest edge of a tile in pixels; 0: as many as make a framebuffer of 4 MB, whatever the size of the image.
  int tile_px = 0;
};

/// A scene with its axes, legend and labels, laid out and ready to be painted: spec.width_px wide, and as high as the
/// window and its labels need. Scene and specification must outlive it. The constructor throws InputError if the size
/// cannot be (see layout.h), EnvironmentError if the font is missing.
class Picture {
 public:
  Picture(const Scene& scene, const SceneSpec& spec);
  Picture(const Picture&) = delete;
  Picture& operator=(const Picture&) = delete;
  ~Picture();

  int width() const;
  int height() const;
  /// What its colours need, whatever the pixels turn out to be.
  Channels channels() const;
  /// Whether there is something that OpenGL could paint.
  bool has_use_for_gl() const;
  /// Whether the processor is done with it before OpenGL would have started.
  bool is_small() const;

  /// Gives the rows from the top, some at a time, so that memory does not grow with the height. Without a context all
  /// is painted by the processor, to the same pixels. Throws EnvironmentError if GL fails, InputError if a force that
  /// is read now is none.
  void paint(GlContext* context, const PaintOptions& options, const PictureRows::Rows& take) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

/// The whole of a picture in memory.
Image paint(const Scene& scene, const SceneSpec& spec, GlContext& context, const PaintOptions& options = {});

/// What is to be told of a scene: what it shows, and what was painted and left out.
ImageMetadata describe(const Scene& scene);

/// Paints the elements of `scene` with OpenGL into the next rows of a picture, as many as the plot area has, from
/// column `left` on. It paints tile by tile, and opens as many rows as a tile has, so that memory does not grow with
/// the height of the picture or the pile; a tile is at most tile_px pixels wide and high, before supersampling (0: as
/// many as suit the supersampling). The pixels do not depend on tile_px. Throws EnvironmentError if a tile exceeds what
/// the driver can paint, or if GL reports an error.
void paint_plot_area(const Scene& scene, const LevelTable& table, Background background, GlContext& context,
                     int tile_px, int left, PictureRows& rows);

/// Paints the elements of `scene` without OpenGL into the next rows of a picture, as many as the plot area has, from
/// column `left` on: element by element, in each row of samples the span that lies inside. The samples are those of
/// paint_plot_area(), decided by the same formula in the same precision, so that the pixels are the same; a test holds
/// the two together.
void paint_spans(const Scene& scene, const LevelTable& table, Background background, int left, PictureRows& rows);

/// Paints the plot area of a pile whose beads are smaller than two pixels, without OpenGL, into the next rows of a
/// picture, from column `left` on. Its samples stand on a grid
/// that is locked to the lattice, 8 to a bead diameter across and 7 to a layer downwards; all contacts of one direction
/// and level then cover the same samples, so that each is painted by laying a stored stamp over those there, the higher
/// level winning. Neighbours share samples and pixels, which take the mean of their samples as everywhere else: only
/// the places of the samples differ from those of the full picture, and strengths below 1/255 of the scale.
///
/// How far the two pictures may be apart is stated as detail_distance (tests/render/picture_distance.h), and held by a
/// test.
void paint_detail(const Scene& scene, const LevelTable& table, Background background, int left, PictureRows& rows);

/// Samples of that grid per bead diameter, across.
inline constexpr int detail_samples_per_diameter = 8;

}  // namespace granuscope
