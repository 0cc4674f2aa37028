//! Imperfect shadow maps: the points that stand for a scene, splatted into one small
//! picture per light.
//!
//! Based on: Ritschel et al., Imperfect Shadow Maps for Efficient Computation of
//! Indirect Illumination, SIGGRAPH Asia 2008; Wyman and Dai, Imperfect Voxelized
//! Shadow Volumes, HPG 2013, section 3.1.2.
//!
//! Departures. The pictures are unfolded octahedra instead of paraboloids, so that a lookup
//! needs no square root. A splat is a square with twice the area that the point stands for, as
//! if it faced the light, so that splats overlap. Holes are filled only if this is [asked
//! for](super::FillHoles).
//!
//! Most of the error is shadow that is too wide, by about half a splat on every side of a
//! caster.

use glam::Vec3;
use gpu_backend::{Backend, Cpu, Host};

use super::ShadowMapAtlas;
use super::atlas::Layout;
use super::map::{EMPTY, ShadowMapError, check_size, texel_along};
use super::octahedron::{HEMISPHERE, SPHERE, octahedral, texels_per_radian, width};
use super::points::{CasterPoints, LevelOfDetail, Taken};
use crate::Emitter;
use crate::scene::raster::{Face, Rays};
use crate::scene::{Bounds, Emission};

/// The largest distance in texels from the middle of a splat to its side. A point so near that
/// its splat would be larger leaves holes.
pub(crate) const MOST_TEXELS: f32 = 12.0;

/// The side of a splat, relative to a square of the area that its point stands for. Squares of
/// just this area around independent points would leave e⁻¹ of a surface uncovered, and these
/// leave e⁻². Points that are spread evenly leave less.
const OVERLAP: f32 = 1.4;

/// Backends that render imperfect shadow maps.
pub trait RenderImperfectMaps: Backend {
    /// The maps of `emitters`, one picture of `resolution` texels per side for each, into which
    /// about `points` of the casters' points are splatted. A point light has a picture of the
    /// sphere, a cosine emitter or a spotlight one of the hemisphere that it lights; a
    /// directional light has a parallel projection of all casters.
    ///
    /// Cost: the points and their texels, whatever the number of triangles.
    ///
    /// # Errors
    /// As for [`RenderShadowMapAtlas::shadow_map_atlas`](super::RenderShadowMapAtlas::shadow_map_atlas).
    fn imperfect_maps(
        &self,
        casters: &CasterPoints<Self::Memory>,
        emitters: &[Emitter],
        resolution: u32,
        points: u32,
        level: LevelOfDetail,
    ) -> Result<ShadowMapAtlas<Self::Memory>, ShadowMapError>;
}

impl Layout {
    /// The layout with one picture per light.
    pub(crate) fn imperfect(bounds: Bounds, emitters: &[Emitter]) -> Self {
        let mut layout = Self::default();
        for emitter in emitters {
            let (face, kind) = picture(bounds, emitter);
            layout.lights.push([layout.faces.len() as u32, kind]);
            layout.faces.push((face, Some(layout.pictures)));
            layout.pictures += 1;
        }
        layout
    }
}

/// The frame of a light, and the kind of picture that it has.
fn picture(bounds: Bounds, emitter: &Emitter) -> (Face, u32) {
    let point = match emitter {
        Emitter::Directional(sun) => return (Face::orthographic(bounds, sun.direction()), 1),
        Emitter::Point(point) => point,
    };
    let (forward, kind) = match point.emission() {
        Emission::Isotropic => (Vec3::Z, SPHERE),
        Emission::Cosine { normal } => (*normal, HEMISPHERE),
        Emission::Spot(spot) => (spot.axis(), HEMISPHERE),
    };
    let right = forward.any_orthonormal_vector();
    let face = Face {
        origin: point.position(),
        right,
        up: right.cross(forward),
        forward,
        rays: Rays::Central { tan: 1.0 },
    };
    (face, kind)
}

/// The position of a light; `None` if it is directional.
pub(crate) fn place(emitter: &Emitter) -> Option<Vec3> {
    match emitter {
        Emitter::Point(point) => Some(point.position()),
        Emitter::Directional(_) => None,
    }
}

/// The distance in texels from the middle of a splat to its side, for a point that stands for 1
/// m². If the light is not directional, this is for a point at 1 m on an axis of the light's
/// frame.
pub(crate) fn splat_scale(face: &Face, kind: u32, resolution: u32) -> [f32; 2] {
    let n = resolution as f32;
    match face.rays {
        Rays::Parallel {
            half_width,
            half_height,
        } => [half_width, half_height].map(|half| 0.25 * OVERLAP * n / half),
        Rays::Central { .. } => [0.5 * OVERLAP * texels_per_radian(kind, resolution); 2],
    }
}

/// Splats the points that a light takes of each cluster.
fn splat(
    casters: &CasterPoints<Host>,
    taken: &[Taken],
    (face, kind): (&Face, u32),
    resolution: u32,
    texels: &mut [f32],
) {
    texels.fill(EMPTY);
    let scale = splat_scale(face, kind, resolution);
    let last = (resolution - 1) as f32;
    for (cluster, taken) in casters.clusters().iter().zip(taken) {
        let first = cluster.first as usize;
        let side = taken.area.sqrt();
        for point in &casters.points()[first..first + taken.count as usize] {
            let v = Vec3::new(point[0], point[1], point[2]) - face.origin;
            let (texel, depth, size) = match face.rays {
                Rays::Parallel { .. } => {
                    let texel = texel_along(face, resolution, v);
                    (texel, v.dot(face.forward).max(0.0), side)
                }
                Rays::Central { .. } => {
                    let depth = v.length();
                    let texel = octahedral(face, kind, resolution, v);
                    (texel, depth, side / (depth * width(face, v)))
                }
            };
            let Some([column, row]) = texel else { continue };
            // The texels whose middle is in the splat, but at least the texel of the point.
            let range = |at: f32, scale: f32| {
                let beyond = (scale * size).clamp(0.5, MOST_TEXELS) - 0.5;
                let ends = [at - beyond, at + beyond];
                let [low, high] = ends.map(|end| end.clamp(0.0, last) as usize);
                low..high + 1
            };
            let columns = range(column, scale[0]);
            for row in range(row, scale[1]) {
                let row = &mut texels[row * resolution as usize..];
                for texel in &mut row[columns.clone()] {
                    *texel = texel.min(depth);
                }
            }
        }
    }
}

impl RenderImperfectMaps for Cpu {
    /// One unit of work is one picture.
    fn imperfect_maps(
        &self,
        casters: &CasterPoints<Host>,
        emitters: &[Emitter],
        resolution: u32,
        points: u32,
        level: LevelOfDetail,
    ) -> Result<ShadowMapAtlas<Host>, ShadowMapError> {
        check_size(emitters.len(), resolution)?;
        let layout = Layout::imperfect(casters.bounds(), emitters);
        let texels = (resolution as usize).pow(2);
        let mut depth = self.zeros::<f32>(emitters.len() * texels)?;
        self.for_each_chunk(&mut depth, texels, |first, picture| {
            let light = first / texels;
            let taken = casters.taken(place(&emitters[light]), points, level);
            let (face, kind) = (&layout.faces[light].0, layout.lights[light][1]);
            splat(casters, &taken, (face, kind), resolution, picture);
        });
        Ok(ShadowMapAtlas::from_depth(layout, resolution, depth))
    }
}
