//! Filtered shadows of several lights on surfaces, from shadow maps.

use glam::Vec3;
use gpu_backend::{Backend, Error, Host, Memory};

use super::depth16::texel_width;
use super::map::{faces, locate};
use super::{Casters, RenderShadowMap, ShadowMapError, reached};
use crate::Emitter;
use crate::direct_light::ShadowsOfMany;
use crate::gather::MOST_TURNS;
use crate::scene::raster::Face;
use crate::visibility::SurfaceShadow;

/// The shadow maps of several lights, in one buffer of the memory `M`.
///
/// Each map covers the casters that its light [reaches](reached). A light that reaches no
/// caster has no picture and casts no shadow.
#[derive(Debug)]
pub struct MapsOfMany<M: Memory> {
    lights: Vec<PicturesOf>,
    resolution: u32,
    depth: M::Buffer<f32>,
}

/// The pictures of one light.
#[derive(Debug, Clone)]
struct PicturesOf {
    faces: Vec<Face>,
    /// The index of its first picture among those of all lights.
    first: u32,
    /// See [`MapsOfMany::with_biases`].
    bias: f32,
}

impl<M: Memory> MapsOfMany<M> {
    /// The default distance in texels by which points are lifted off their surface, beyond half
    /// the width of the filter.
    pub const BIAS: f32 = 1.0;

    /// Renders the maps of `emitters` with `resolution` texels per side and face.
    ///
    /// # Errors
    /// As for [`RenderShadowMap::shadow_map`], of all of them together.
    pub fn render<B>(
        backend: &B,
        casters: &Casters<M>,
        emitters: &[Emitter],
        resolution: u32,
    ) -> Result<Self, ShadowMapError>
    where
        B: RenderShadowMap + Backend<Memory = M>,
    {
        let lights = pictures(casters, emitters);
        let faces: Vec<Face> = lights
            .iter()
            .flat_map(|light| light.faces.clone())
            .collect();
        Ok(Self {
            depth: backend.depths(casters, &faces, resolution)?,
            lights,
            resolution,
        })
    }

    /// Number of pictures that the maps of these lights have together. A picture has
    /// resolution² texels.
    pub fn picture_count(casters: &Casters<M>, emitters: &[Emitter]) -> usize {
        let lights = pictures(casters, emitters);
        lights.iter().map(|light| light.faces.len()).sum()
    }

    /// The same maps with a bias for each light, in texels, at least 0. A point is lifted off
    /// its surface by the bias plus half the width of the filter. Lights for which no bias is
    /// given keep theirs, which is [`MapsOfMany::BIAS`] at first.
    #[must_use]
    pub fn with_biases(mut self, biases: &[f32]) -> Self {
        for (light, bias) in self.lights.iter_mut().zip(biases) {
            light.bias = bias.max(0.0);
        }
        self
    }

    /// For each light: its faces, the index of the first of its pictures, and its bias.
    #[cfg(feature = "wgpu")]
    pub(crate) fn pictures(&self) -> impl Iterator<Item = (&[Face], u32, f32)> {
        let lights = self.lights.iter();
        lights.map(|light| (&light.faces[..], light.first, light.bias))
    }

    /// The depths of all pictures.
    #[cfg(feature = "wgpu")]
    pub(crate) fn depth(&self) -> &M::Buffer<f32> {
        &self.depth
    }

    /// Texels per side of each picture.
    pub fn resolution(&self) -> u32 {
        self.resolution
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        let faces: usize = self.lights.iter().map(|light| light.faces.len()).sum();
        4 * faces as u64 * u64::from(self.resolution).pow(2)
    }

    /// Shadows on surfaces: the lit share of the `width × width` texels around a point. Even
    /// widths count as the next odd one, and those above 65535 as 65535.
    ///
    /// The point is lifted along its normal by half of that width plus the light's
    /// [bias](MapsOfMany::with_biases), as for precomputed shadows. Texels beyond the border of
    /// a picture repeat those at the border; points outside of all pictures are lit.
    pub fn filtered(&self, width: u32) -> FilteredMapsOfMany<'_, M> {
        FilteredMapsOfMany {
            maps: self,
            half: width.min(u16::MAX.into()) / 2,
        }
    }
}

impl MapsOfMany<Host> {
    /// Copies the maps to another backend.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if they do not fit there.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<MapsOfMany<B::Memory>, Error> {
        Ok(MapsOfMany {
            lights: self.lights.clone(),
            resolution: self.resolution,
            depth: backend.upload(&self.depth)?,
        })
    }
}

/// The pictures of each light; none for a light that reaches no caster.
fn pictures<M: Memory>(casters: &Casters<M>, emitters: &[Emitter]) -> Vec<PicturesOf> {
    let mut first = 0;
    let of_light = |emitter: &Emitter| {
        let within = reached(casters.bounds(), emitter);
        let faces = within.map_or_else(Vec::new, |within| faces(within, emitter));
        let own = first;
        first += faces.len() as u32;
        PicturesOf {
            faces,
            first: own,
            bias: MapsOfMany::<M>::BIAS,
        }
    };
    emitters.iter().map(of_light).collect()
}

/// Filtered shadows from [`MapsOfMany`].
#[derive(Debug)]
pub struct FilteredMapsOfMany<'a, M: Memory> {
    maps: &'a MapsOfMany<M>,
    /// Texels on either side of the middle one.
    half: u32,
}

impl<M: Memory> Clone for FilteredMapsOfMany<'_, M> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M: Memory> Copy for FilteredMapsOfMany<'_, M> {}

impl<'a, M: Memory> FilteredMapsOfMany<'a, M> {
    /// The maps that are filtered.
    pub fn maps(&self) -> &'a MapsOfMany<M> {
        self.maps
    }

    /// Texels along each side of the filter.
    pub fn width(&self) -> u32 {
        2 * self.half + 1
    }

    /// How many lights of a point one dispatch should take, for
    /// [`LitPoints`](crate::direct_light::LitPoints): so many that an invocation runs some
    /// 50,000 iterations of its loops, which drivers allow. A single light exceeds this with
    /// filters wider than some 200 texels.
    pub fn lights_per_dispatch(&self) -> usize {
        let texels = f64::from(self.width()).powi(2) + f64::from(self.width());
        (MOST_TURNS / texels).max(1.0) as usize
    }
}

impl<'a> FilteredMapsOfMany<'a, Host> {
    /// The shadows of the light with this index. With an index of no light everything is in
    /// shadow.
    pub fn of_light(&self, light: usize) -> impl SurfaceShadow + use<'a> {
        OfLight { maps: *self, light }
    }
}

/// The shadows of one light.
#[derive(Debug)]
struct OfLight<'a> {
    maps: FilteredMapsOfMany<'a, Host>,
    light: usize,
}

impl SurfaceShadow for OfLight<'_> {
    fn visibility(&self, point: Vec3, normal: Vec3) -> Vec3 {
        ShadowsOfMany::visibility(&self.maps, self.light, point, normal)
    }
}

impl ShadowsOfMany for FilteredMapsOfMany<'_, Host> {
    fn visibility(&self, light: usize, point: Vec3, normal: Vec3) -> Vec3 {
        let maps = self.maps;
        let Some(PicturesOf { faces, first, bias }) = maps.lights.get(light) else {
            return Vec3::ZERO;
        };
        if faces.is_empty() {
            return Vec3::ONE;
        }
        let width = self.width();
        let lift = texel_width(faces, maps.resolution, point) * (0.5 * width as f32 + bias);
        let Some(place) = locate(faces, maps.resolution, point + lift * normal) else {
            return Vec3::ONE;
        };
        let picture = *first as usize + place.face;
        let (side, half) = (i64::from(maps.resolution), i64::from(self.half));
        let clamped = |at: i64| at.clamp(0, side - 1) as usize;
        let [column, row] = place.texel.map(|at| at as i64);
        let mut lit = 0;
        for y in row - half..=row + half {
            let start = (picture * side as usize + clamped(y)) * side as usize;
            for x in column - half..=column + half {
                let depth = maps.depth[start + clamped(x)];
                lit += u32::from(place.depth <= depth);
            }
        }
        Vec3::splat(lit as f32 / (width as f32).powi(2))
    }
}

#[cfg(test)]
mod tests {
    use glam::Quat;
    use gpu_backend::Cpu;

    use super::*;
    use crate::scene::{Cone, Emission, Geometry, Mesh, Scene};

    /// A square of 2 m a side at the height 2.
    fn square() -> Geometry {
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
        Geometry::new(&Scene::from(Mesh {
            positions: corners.map(|(x, z)| Vec3::new(x, 2.0, z)).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }))
        .unwrap()
    }

    fn lamp(height: f32, range: f32, emission: Emission) -> Emitter {
        Emitter::point(height * Vec3::Y, Vec3::ONE, range, emission).unwrap()
    }

    #[test]
    fn every_light_has_the_shadow_of_the_square_and_those_that_do_not_reach_it_none() {
        let cpu = Cpu::new();
        let cone = Cone {
            inner: 0.5,
            outer: 0.9,
        };
        let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let up = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        let spot = |turn| Emission::spot(turn, cone, None).unwrap();
        let forever = f32::INFINITY;
        // Where the rim of the shadow is on the floor.
        let lights = [
            (lamp(6.0, forever, spot(down)), Some(1.5)),
            (lamp(6.0, 3.0, Emission::Isotropic), None),
            (lamp(4.0, forever, Emission::Isotropic), Some(2.0)),
            (
                Emitter::directional(Vec3::NEG_Y, Vec3::ONE).unwrap(),
                Some(1.0),
            ),
            (lamp(6.0, forever, spot(up)), None),
            (lamp(4.0, 4.5, Emission::Isotropic), Some(2.0)),
        ];
        let emitters = lights.clone().map(|(emitter, _)| emitter);
        let casters = Casters::upload(&cpu, &square()).unwrap();
        let maps = MapsOfMany::render(&cpu, &casters, &emitters, 512).unwrap();
        let pictures = MapsOfMany::picture_count(&casters, &emitters);
        assert_eq!(maps.bytes(), 4 * 512 * 512 * pictures as u64);
        for width in [1, 3, 9] {
            let filtered = maps.filtered(width);
            for (light, (_, rim)) in lights.iter().enumerate() {
                let shadow = filtered.of_light(light);
                let at = |x: f32| shadow.visibility(x * Vec3::X, Vec3::Y).x;
                match rim {
                    None => assert_eq!([at(0.0), at(1.0)], [1.0; 2], "{light}"),
                    Some(rim) => {
                        assert_eq!([at(0.0), at(0.9 * rim)], [0.0; 2], "{light}");
                        assert_eq!([at(1.1 * rim), at(5.0)], [1.0; 2], "{light}");
                        let edge = (0..40).map(|i| at(rim * (0.9 + 0.005 * i as f32)));
                        assert!(edge.is_sorted(), "{light}");
                    }
                }
            }
            // A light that nothing is known of.
            assert_eq!(
                filtered.of_light(6).visibility(Vec3::ZERO, Vec3::Y),
                Vec3::ZERO
            );
        }
    }

    #[test]
    fn a_bias_of_a_light_is_its_own() {
        let cpu = Cpu::new();
        let sun = Emitter::directional(Vec3::new(1.0, -1.0, 0.0), Vec3::ONE).unwrap();
        let casters = Casters::upload(&cpu, &square()).unwrap();
        let both = [sun.clone(), sun];
        let maps = MapsOfMany::render(&cpu, &casters, &both, 64).unwrap();
        let maps = maps.with_biases(&[1.0, 40.0]);
        let widest = [0, 1, 65_535, 65_536, u32::MAX].map(|width| maps.filtered(width).width());
        assert_eq!(widest, [1, 1, 65_535, 65_535, 65_535]);
        let filtered = maps.filtered(1);
        // Under the rim a point that is lifted far is in front of the square.
        let below = Vec3::new(0.0, 1.8, 0.0);
        let [usual, lifted] =
            [0, 1].map(|light| filtered.of_light(light).visibility(below, Vec3::Y));
        assert_eq!([usual, lifted], [Vec3::ZERO, Vec3::ONE]);
    }
}
