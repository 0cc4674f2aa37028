//! The light that hair scatters towards the eye.

use std::fmt::Debug;

use glam::{DVec3, Vec3};
use gpu_backend::{Cpu, Host};
use transmittance::{Evaluate, Packed};

use super::fragments::Fragment;
use super::{Fibre, SeenHair};
use crate::Ray;
use crate::methods::translucent::TransmittanceMap;
use crate::scene::trace::{Pane, Tracer};
use crate::scene::view::View;
use crate::scene::{Emitter, Media, Medium, Translucent};
use crate::surface_point::{Arriving, transmittance};

/// The lights and the media around hair that is seen; `T` are the curves of the transmittance
/// maps.
#[derive(Debug)]
pub struct LitHair<'a, T: Debug = Packed<8>> {
    /// The view that shows the hair.
    pub view: &'a View,
    /// The translucent casters of the scene, the hair among them.
    pub translucent: &'a [Translucent],
    /// The fog and smoke of the scene.
    pub media: &'a Media<'a>,
    /// The triangles of the scene, for shadow rays.
    pub tracer: &'a Tracer,
    /// The lights, each with a map of what strands, smoke and particles let through. Triangles
    /// must not be in the maps, because they are traced.
    pub lights: &'a [(&'a Emitter, &'a TransmittanceMap<Host, T>)],
    /// How strands scatter light.
    pub fibre: Fibre,
}

impl SeenHair {
    /// The radiance of the hair that reaches the eye, one RGB0 per ray of the view. Add it to
    /// the light behind the hair after the [cover](SeenHair::cover) has dimmed that.
    pub fn radiance<T>(&self, cpu: &Cpu, lit: &LitHair<'_, T>) -> Vec<[f32; 4]>
    where
        T: Evaluate + Debug + Sync,
    {
        cpu.map(lit.view.rays().len(), |pixel| {
            let fragments = self.of(pixel);
            if fragments.is_empty() || lit.lights.is_empty() {
                return [0.0; 4];
            }
            let ray = &lit.view.rays()[pixel];
            let mut before = Before::new(lit.media, ray, fragments, lit.view.panes(pixel));
            let (mut sum, mut left) = (Vec3::ZERO, 1.0);
            for (index, fragment) in fragments.iter().enumerate() {
                let seen = before.share(index, fragment.distance);
                let weight = left * fragment.alpha * seen;
                if weight != Vec3::ZERO {
                    sum += weight * lit.scattered(ray, fragment);
                }
                left *= 1.0 - fragment.alpha;
            }
            [sum.x, sum.y, sum.z, 0.0]
        })
    }
}

/// How far from the axis of a strand a transmittance map is asked, in texels. A filter reads
/// what the strand has written up to a texel away, and within that texel.
const TEXELS: f32 = 2.0;

impl<T: Evaluate + Debug> LitHair<'_, T> {
    /// The light that a strand sends towards the origin of the ray.
    fn scattered(&self, ray: &Ray, fragment: &Fragment) -> Vec3 {
        let caster = self.translucent.get(fragment.caster as usize);
        let strands = match caster {
            Some(Translucent::Strands(strands))
                if (fragment.piece as usize) < strands.piece_count() =>
            {
                strands
            }
            _ => return Vec3::ZERO,
        };
        let piece = strands.piece(fragment.piece as usize);
        let colour = strands.colour(fragment.piece as usize, fragment.share);
        let [a, b] = piece.axis;
        let (point, tangent) = (a.lerp(b, fragment.share), (b - a).normalize_or_zero());
        let to_eye = (ray.origin() - point).normalize_or_zero();
        let lights = self.lights.iter().map(|(emitter, map)| {
            let Some(light) = Arriving::at(point, emitter) else {
                return Vec3::ZERO;
            };
            if light.irradiance == Vec3::ZERO {
                return Vec3::ZERO;
            }
            let scattered = self.fibre.radiance(colour, tangent, light.to_light, to_eye);
            if scattered == Vec3::ZERO {
                return Vec3::ZERO;
            }
            let nearer = piece.radius + TEXELS * map.texel_size(point);
            // The point must not lie beyond the light.
            let nearer = nearer.min(0.5 * light.distance);
            let share = map.transmittance(point + nearer * light.to_light);
            if share == Vec3::ZERO {
                return Vec3::ZERO;
            }
            let traced = self
                .tracer
                .transmittance(point, light.to_light, 0.0, light.distance);
            let mut fog = light.through(self.media.medium(), point);
            if let Some(height) = self.media.height_fog() {
                let (y, slope) = (f64::from(point.y), f64::from(light.to_light.y));
                let depth = height.depth_towards(y, slope, light.distance.into());
                fog *= (-depth).exp().as_vec3();
            }
            light.irradiance * scattered * share * traced * fog
        });
        lights.sum()
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
