//! The light that hair scatters towards the eye.

use std::fmt::Debug;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};
use gpu_backend::{Backend, BufferOf, Cpu, Error, Host};
use transmittance::{Evaluate, Packed};

use super::fragments::Fragment;
use super::{Fibre, SeenHair};
use crate::Ray;
use crate::gather::check_lengths;
use crate::methods::translucent::{CurveMemory, TransmittanceMap};
use crate::scene::trace::{Pane, Tracer};
use crate::scene::view::View;
use crate::scene::{Emitter, Media, Medium, Translucent};
use crate::surface_point::{Arriving, transmittance};

/// The lights and the media around hair that is seen, in the memory `M`; `T` are the curves of
/// the transmittance maps.
#[derive(Debug)]
pub struct LitHair<'a, M: HairMemory<T> = Host, T = Packed<8>> {
    /// The view that shows the hair.
    pub view: &'a View,
    /// The translucent casters of the scene, the hair among them.
    pub translucent: &'a [Translucent],
    /// The fog and smoke of the scene.
    pub media: &'a Media<'a>,
    /// The triangles of the scene, for shadow rays.
    pub tracer: &'a M::Tracer,
    /// The lights, each with a map of what strands, smoke and particles let through. Triangles
    /// must not be in the maps, because they are traced.
    pub lights: &'a [(&'a Emitter, &'a TransmittanceMap<M, T>)],
    /// How strands scatter light.
    pub fibre: Fibre,
}

/// A memory that can hold what lights hair: curves of the type `T`, and triangles.
pub trait HairMemory<T>: CurveMemory<T> {
    /// The triangles of a scene, for shadow rays.
    type Tracer: Debug;
}

impl<T: Debug> HairMemory<T> for Host {
    type Tracer = Tracer;
}

/// The step that adds the light of hair to the pixels that show it.
///
/// It is implemented on the CPU for curves of any kind, and on GPUs for those that bring a
/// shader part.
pub trait AddHairLight<T>: Backend<Memory: HairMemory<T>> {
    /// Adds to the first three components of `radiance[i]` the light of the hair that reaches
    /// the eye along ray i of the view. What is behind the hair must have been dimmed by its
    /// [cover](SeenHair::cover), before or after that.
    ///
    /// # Errors
    /// [`Error::LengthMismatch`] if the number of sums is not that of the rays of the view, or
    /// if the hair was found for another number of pixels; nothing is written then. On a GPU
    /// [`Error::TooLarge`] if a pixel shows more strands than a binding holds, at 80 bytes each.
    fn add_hair_light(
        &self,
        hair: &SeenHair,
        lit: &LitHair<'_, Self::Memory, T>,
        radiance: &mut BufferOf<Self, [f32; 4]>,
    ) -> Result<(), Error>;
}

impl<T: Evaluate + Debug + Sync> AddHairLight<T> for Cpu {
    fn add_hair_light(
        &self,
        hair: &SeenHair,
        lit: &LitHair<'_, Host, T>,
        radiance: &mut Vec<[f32; 4]>,
    ) -> Result<(), Error> {
        lit.check(hair, radiance.len())?;
        self.for_each_chunk(radiance, CHUNK, |first, chunk| {
            for (pixel, sum) in (first..).zip(chunk) {
                let mut light = Vec3::ZERO;
                lit.for_each_point(hair, pixel, |point| light += lit.scattered(&point));
                for (sum, light) in sum.iter_mut().zip(light.to_array()) {
                    *sum += light;
                }
            }
        });
        Ok(())
    }
}

/// Pixels of a unit of work.
const CHUNK: usize = 64;

/// How far from the axis of a strand a transmittance map is asked, in texels. A filter reads
/// what the strand has written up to a texel away, and within that texel.
pub(super) const TEXELS: f32 = 2.0;

/// A point of a strand that the eye sees. Its memory layout is five `vec4<f32>`, which is what
/// shaders read.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(super) struct HairPoint {
    pub(super) position: Vec3,
    pub(super) radius: f32,
    /// The unit vector towards the tip of the strand.
    pub(super) tangent: Vec3,
    pub(super) padding_a: u32,
    /// The unit vector towards the eye.
    pub(super) to_eye: Vec3,
    pub(super) padding_b: u32,
    pub(super) colour: Vec3,
    pub(super) padding_c: u32,
    /// The share of its light that reaches the eye.
    pub(super) response: Vec3,
    pub(super) padding_d: u32,
}

impl<M: HairMemory<T>, T> LitHair<'_, M, T> {
    pub(super) fn check(&self, hair: &SeenHair, radiance: usize) -> Result<(), Error> {
        let rays = self.view.rays().len();
        check_lengths(rays, radiance)?;
        if hair.pixels() == rays {
            return Ok(());
        }
        Err(Error::LengthMismatch {
            what: "the pixels of hair",
            expected: rays,
            actual: hair.pixels(),
        })
    }

    /// Visits the points of a pixel whose light reaches the eye, the nearest first.
    pub(super) fn for_each_point(
        &self,
        hair: &SeenHair,
        pixel: usize,
        mut visit: impl FnMut(HairPoint),
    ) {
        let fragments = hair.of(pixel);
        if fragments.is_empty() || self.lights.is_empty() {
            return;
        }
        let ray = &self.view.rays()[pixel];
        let mut before = Before::new(self.media, ray, fragments, self.view.panes(pixel));
        let mut left = 1.0;
        for (index, fragment) in fragments.iter().enumerate() {
            let response = left * fragment.alpha * before.share(index, fragment.distance);
            if response != Vec3::ZERO
                && let Some(point) = self.point(ray, fragment, response)
            {
                visit(point);
            }
            left *= 1.0 - fragment.alpha;
        }
    }

    fn point(&self, ray: &Ray, fragment: &Fragment, response: Vec3) -> Option<HairPoint> {
        let Some(Translucent::Strands(strands)) = self.translucent.get(fragment.caster as usize)
        else {
            return None;
        };
        let index = fragment.piece as usize;
        if index >= strands.piece_count() {
            return None;
        }
        let piece = strands.piece(index);
        let [a, b] = piece.axis;
        let position = a.lerp(b, fragment.share);
        Some(HairPoint {
            position,
            radius: piece.radius,
            tangent: (b - a).normalize_or_zero(),
            to_eye: (ray.origin() - position).normalize_or_zero(),
            colour: strands.colour(index, fragment.share),
            response,
            ..HairPoint::zeroed()
        })
    }
}

impl<T: Evaluate + Debug> LitHair<'_, Host, T> {
    /// The light of a point of a strand that reaches the eye.
    fn scattered(&self, point: &HairPoint) -> Vec3 {
        let position = point.position;
        let lights = self.lights.iter().map(|(emitter, map)| {
            let Some(light) = Arriving::at(position, emitter) else {
                return Vec3::ZERO;
            };
            if light.irradiance == Vec3::ZERO {
                return Vec3::ZERO;
            }
            let HairPoint {
                colour,
                tangent,
                to_eye,
                ..
            } = *point;
            let scattered = self.fibre.radiance(colour, tangent, light.to_light, to_eye);
            if scattered == Vec3::ZERO {
                return Vec3::ZERO;
            }
            let nearer = point.radius + TEXELS * map.texel_size(position);
            // The point must not lie beyond the light.
            let nearer = nearer.min(0.5 * light.distance);
            let share = map.transmittance(position + nearer * light.to_light);
            if share == Vec3::ZERO {
                return Vec3::ZERO;
            }
            let traced = (self.tracer).transmittance(position, light.to_light, 0.0, light.distance);
            let mut fog = light.through(self.media.medium(), position);
            if let Some(height) = self.media.height_fog() {
                let (y, slope) = (f64::from(position.y), f64::from(light.to_light.y));
                let depth = height.depth_towards(y, slope, light.distance.into());
                fog *= (-depth).exp().as_vec3();
            }
            light.irradiance * scattered * share * traced * fog
        });
        point.response * lights.sum::<Vec3>()
    }
}

/// What dims the light of a ray's fragments on its way to the eye.
struct Before<'a> {
    even: Option<(&'a Medium, &'a Ray)>,
    /// Optical depths of the heterogeneous media in front of each fragment.
    depths: Vec<DVec3>,
    panes: &'a [Pane],
    through_panes: Vec3,
}

impl<'a> Before<'a> {
    fn new(media: &'a Media<'a>, ray: &'a Ray, fragments: &[Fragment], panes: &'a [Pane]) -> Self {
        let mut depths = Vec::new();
        if !media.is_homogeneous() {
            depths = depths_to(media, ray, fragments);
        }
        Self {
            even: media.medium().map(|medium| (medium, ray)),
            depths,
            panes,
            through_panes: Vec3::ONE,
        }
    }

    /// The share that arrives from a fragment. Fragments must be asked about in order.
    fn share(&mut self, index: usize, distance: f32) -> Vec3 {
        while let [pane, others @ ..] = self.panes
            && pane.hit.distance < distance
        {
            self.through_panes *= pane.transmittance;
            self.panes = others;
        }
        let fog = match (self.depths.get(index), self.even) {
            (Some(depth), _) => (-*depth).exp().as_vec3(),
            (None, None) => Vec3::ONE,
            (None, Some((medium, ray))) => {
                transmittance(Some(medium), ray.origin(), ray.direction(), distance)
            }
        };
        self.through_panes * fog
    }
}

/// Optical depths along a ray in front of each fragment.
fn depths_to(media: &Media<'_>, ray: &Ray, fragments: &[Fragment]) -> Vec<DVec3> {
    let mut depths = Vec::with_capacity(fragments.len());
    let direction = ray.direction().as_dvec3().normalize();
    let end = fragments.last().map_or(0.0, |last| last.distance);
    let mut pieces = media.along(ray.origin().as_dvec3(), direction, 0.0, end.into());
    let mut behind = DVec3::ZERO;
    while let Some(piece) = pieces.advance() {
        while let Some(next) = fragments.get(depths.len())
            && f64::from(next.distance) <= piece.end()
        {
            depths.push(piece.depth_to(next.distance.into()));
        }
        behind = piece.depth_to(piece.end());
    }
    depths.resize(fragments.len(), behind);
    depths
}
