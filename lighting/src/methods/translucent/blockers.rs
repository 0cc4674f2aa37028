//! The blockers on the rays of a face, as segments per texel.

use gpu_backend::Cpu;
use transmittance::{BlockerSegment, Source, Tile};

use super::bins::Bins;
use super::panes::Panes;
use super::particles::Ball;
use super::strands::Outline;
use super::view::{Texels, View};
use super::{Casters, grid};
use crate::scene::raster::Face;
use crate::scene::{DensityGrid, Particles, Strands, Translucent};
use crate::shadow_map::{EMPTY, Masked, render_face};

/// The blockers of a scene in the picture of a light or of a camera: a [`Source`] of segments
/// for a map of curves.
///
/// The segments of a texel come in the order of the casters and of their parts. See-through
/// triangles come after those, each as a surface, and opaque triangles last, as one opaque
/// segment at the nearest of them. Memory is at most four numbers per strand piece and
/// particle, about 11 bytes per caster and 16 × 16 texels, 200 bytes per see-through triangle,
/// and one number per texel if there are opaque triangles. Segments are made anew for each
/// tile.
///
/// The segments are those of red light, unless [another channel](FaceBlockers::of_channel) is
/// asked for. Colours differ where [`Casters::channels`] says so.
#[derive(Debug)]
pub struct FaceBlockers<'a> {
    view: View,
    layers: Vec<Layer<'a>>,
    panes: Option<Panes>,
    /// The colour channel of the segments.
    channel: usize,
    /// Depth of the nearest opaque triangle in each texel; empty if there are none.
    opaque: Vec<f32>,
    depths: [f32; 2],
}

#[derive(Debug)]
enum Layer<'a> {
    Strands(&'a Strands, Bins),
    Grid(&'a DensityGrid, Texels),
    Particles(&'a Particles, Bins),
}

impl<'a> FaceBlockers<'a> {
    /// Sorts the casters by the texels that they may touch, and draws the opaque triangles.
    /// `resolution` is the number of texels per side, at most 16384.
    pub(crate) fn new(
        cpu: &Cpu,
        casters: &Casters<'a>,
        face: &Face,
        resolution: u32,
    ) -> FaceBlockers<'a> {
        let view = View::new(face, resolution);
        let layer = |caster: &'a Translucent| match caster {
            Translucent::Strands(strands) => {
                let texels = |index: usize| {
                    Outline::new(&view, &strands.piece(index)).and_then(|it| it.texels(&view))
                };
                let bins = Bins::new(resolution, strands.piece_count(), texels);
                Some(Layer::Strands(strands, bins))
            }
            Translucent::Grid(grid) => {
                let texels = view.of_box(grid.occupied_bounds())?;
                Some(Layer::Grid(grid, texels))
            }
            Translucent::Particles(particles) => {
                let texels = |index: usize| {
                    Ball::new(&view, &particles.all()[index], particles.profile()).texels(&view)
                };
                let bins = Bins::new(resolution, particles.all().len(), texels);
                Some(Layer::Particles(particles, bins))
            }
        };
        let layers = casters.translucent.iter().filter_map(layer).collect();
        let panes = casters.triangles.panes();
        let panes = panes.and_then(|geometry| Panes::new(geometry, face, resolution));
        Self {
            depths: depths(&view, casters),
            view,
            layers,
            panes,
            channel: 0,
            opaque: opaque_depths(cpu, casters, face, resolution).unwrap_or_default(),
        }
    }

    /// The same blockers in the colour channel of this index, 0 to 2; larger numbers count as
    /// 2.
    #[must_use]
    pub fn of_channel(self, channel: usize) -> Self {
        Self {
            channel: channel.min(2),
            ..self
        }
    }

    /// Texels per side.
    pub fn resolution(&self) -> u32 {
        self.view.resolution()
    }

    /// The depths between which all blockers lie, from the corners of a box around them, for
    /// methods that need a range of depths.
    pub fn depths(&self) -> [f32; 2] {
        self.depths
    }
}

impl Source for FaceBlockers<'_> {
    fn segments(&self, tile: &Tile, put: &mut dyn FnMut([usize; 2], BlockerSegment)) {
        let view = &self.view;
        for layer in &self.layers {
            match layer {
                Layer::Strands(strands, bins) => {
                    for index in bins.of_tile(tile) {
                        let outline = Outline::new(view, &strands.piece(index as usize));
                        if let Some(outline) = outline
                            && let Some(texels) = outline.texels(view)
                            && let Some(texels) = texels.within(tile)
                        {
                            outline.segments(view, texels, put);
                        }
                    }
                }
                Layer::Grid(grid, texels) => {
                    if let Some(texels) = texels.within(tile) {
                        grid::segments(grid, view, texels, self.channel, put);
                    }
                }
                Layer::Particles(particles, bins) => {
                    for index in bins.of_tile(tile) {
                        let particle = &particles.all()[index as usize];
                        let ball = Ball::new(view, particle, particles.profile());
                        if let Some(texels) = ball.texels(view)
                            && let Some(texels) = texels.within(tile)
                        {
                            ball.segments(view, texels, put);
                        }
                    }
                }
            }
        }
        if let Some(panes) = &self.panes {
            panes.segments(tile, self.channel, put);
        }
        if self.opaque.is_empty() {
            return;
        }
        let Some(texels) = view.all().within(tile) else {
            return;
        };
        texels.for_each(|x, y| {
            let depth = self.opaque[(y * view.resolution() + x) as usize];
            // A texel without opaque triangles has the depth EMPTY.
            if depth < EMPTY
                && let Ok(segment) = BlockerSegment::opaque(depth)
            {
                put([x as usize, y as usize], segment);
            }
        });
    }
}

/// The depth of the nearest opaque triangle in each texel of a face, [`EMPTY`] where there is
/// none; `None` if none of the casters is opaque.
pub(super) fn opaque_depths(
    cpu: &Cpu,
    casters: &Casters<'_>,
    face: &Face,
    resolution: u32,
) -> Option<Vec<f32>> {
    let geometry = casters.triangles.opaque()?;
    let mut depths = vec![EMPTY; (resolution as usize).pow(2)];
    let masked = Masked::new(geometry);
    let order = masked.order(geometry);
    let triangles = order.as_deref().unwrap_or(geometry.triangles());
    render_face(cpu, face, triangles, &masked, resolution, &mut depths);
    Some(depths)
}

/// The depths of a box around all casters, slightly widened; `[0, 1]` if there are none.
fn depths(view: &View, casters: &Casters<'_>) -> [f32; 2] {
    let Some(bounds) = casters.bounds() else {
        return [0.0, 1.0];
    };
    let local = bounds.corners().map(|corner| view.local(corner));
    let (mut near, mut far) = (f64::INFINITY, f64::NEG_INFINITY);
    for corner in local {
        (near, far) = (near.min(view.depth(corner)), far.max(view.depth(corner)));
    }
    if !view.is_parallel() {
        // The nearest point of the box may be on a face, or the origin may be inside.
        let min = local.into_iter().fold(local[0], glam::DVec3::min);
        let max = local.into_iter().fold(local[0], glam::DVec3::max);
        near = glam::DVec3::ZERO.clamp(min, max).length();
    }
    let margin = (1e-5 * (far - near)).max(1e-6 * far.abs());
    [(near - margin) as f32, (far + margin) as f32]
}
