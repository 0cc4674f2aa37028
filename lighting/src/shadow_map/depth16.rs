//! Shadow maps as game engines keep them: depths of 16 bits, cascades for a sun, and a filter
//! over the texels around a point of a surface.
//!
//! They are baselines with which other shadows are compared. Cascades are based on: Zhang, Sun,
//! Xu and Lun, Parallel-Split Shadow Maps for Large-Scale Virtual Environments, VRCIA 2006
//! (their practical split scheme); and Valient, Stable Rendering of Cascaded Shadow Maps,
//! ShaderX6, 2008.

use std::ops::RangeInclusive;

use glam::Vec3;
use gpu_backend::{Cpu, Host};

use super::map::{check_size, face_along, faces, render_face};
use super::{Casters, EMPTY, ShadowMapError, locate};
use crate::Emitter;
use crate::scene::raster::{Face, Rays};
use crate::scene::{Camera, DirectionalEmitter};
use crate::visibility::SurfaceShadow;

/// Number of cascades for a sun.
const CASCADES: usize = 4;

/// The weight of the logarithmic split in the practical one; the rest is the even split.
const LOGARITHMIC: f32 = 0.5;

/// The distances between which cascades may lie, m. Within this range the ratio of two
/// distances, and the radius of the widest view, do not overflow single precision.
const DISTANCES: RangeInclusive<f32> = 1e-12..=1e12;

/// Depth of a texel in which the light sees nothing.
const NOTHING: u16 = u16::MAX;

/// Shadow maps of one light with depths of 16 bits.
///
/// Depths are spaced evenly between the nearest and the farthest one of a picture, which loses
/// less than the projective depths of a rasteriser. They are rounded away from the light.
#[derive(Debug, Clone)]
pub struct Depth16Maps {
    faces: Vec<Face>,
    resolution: u32,
    depth: Vec<u16>,
    /// The nearest depth of each picture, and the step from one depth to the next.
    ranges: Vec<[f32; 2]>,
    cascades: Option<Splits>,
}

/// What tells which cascade shows a point.
#[derive(Debug, Clone, Copy)]
struct Splits {
    eye: Vec3,
    forward: Vec3,
    /// The distance along the view at which each cascade ends.
    ends: [f32; CASCADES],
}

impl Depth16Maps {
    /// The pictures that a [`ShadowMap`](super::ShadowMap) of `resolution` texels per side has:
    /// one for a sun or a spotlight, or six.
    ///
    /// # Errors
    /// As for [`RenderShadowMap::shadow_map`](super::RenderShadowMap::shadow_map).
    pub fn new(
        cpu: &Cpu,
        casters: &Casters<Host>,
        emitter: &Emitter,
        resolution: u32,
    ) -> Result<Self, ShadowMapError> {
        let faces = faces(casters.bounds(), emitter);
        Self::of_faces(cpu, casters, faces, resolution)
    }

    /// Four cascades of a sun, of `resolution` texels per side each, over the part of a
    /// camera's view of `[width, height]` pixels, at least 1 each, that lies between two
    /// distances along its axis, 10⁻¹² m ≤ near < far ≤ 10¹² m. Points nearer than `near`
    /// are looked up in the first cascade, points beyond `far` in the last one; what a cascade
    /// does not show is lit.
    ///
    /// Splits are the mean of logarithmic and even ones. Each cascade is a square around the
    /// bounding sphere of its part of the view. It keeps its size whichever way the camera
    /// looks and moves by whole texels, so that edges of shadows do not crawl as the camera
    /// moves. Every cascade shows all casters between the sun and the view.
    ///
    /// # Errors
    /// [`ShadowMapError::CascadeDistances`] and [`ShadowMapError::ViewSize`] for values outside
    /// of these ranges, NaN among them; else as for [`Depth16Maps::new`].
    pub fn cascades(
        cpu: &Cpu,
        casters: &Casters<Host>,
        sun: &DirectionalEmitter,
        (camera, [width, height], [near, far]): (&Camera, [u32; 2], [f32; 2]),
        resolution: u32,
    ) -> Result<Self, ShadowMapError> {
        let is_allowed = |distance: &f32| DISTANCES.contains(distance);
        if !([near, far].iter().all(is_allowed) && near < far) {
            return Err(ShadowMapError::CascadeDistances { near, far });
        }
        if width == 0 || height == 0 {
            return Err(ShadowMapError::ViewSize { width, height });
        }
        let (w, h) = (width as f32, height as f32);
        let forward = camera.direction(0.5 * w, 0.5 * h, width, height);
        let cos = forward.dot(camera.direction(0.0, 0.0, width, height));
        // The square of the tangent of the angle between the axis and a corner of the view.
        let spread = (cos * cos).recip() - 1.0;
        let end = |i: usize| {
            let share = i as f32 / CASCADES as f32;
            let even = near + (far - near) * share;
            LOGARITHMIC * near * (far / near).powf(share) + (1.0 - LOGARITHMIC) * even
        };
        let ends: [f32; CASCADES] = std::array::from_fn(|i| end(i + 1));
        // Axes and depths do not depend on the camera: the depths are those of all casters.
        let whole = Face::orthographic(casters.bounds(), sun.direction());
        let of_part = |i: usize| {
            let (middle, radius) = sphere(spread, end(i), ends[i]);
            // A margin of half a texel on each side, by which rounding may move the square.
            let radius = radius * (1.0 + 1.0 / resolution.max(1) as f32);
            let texel = 2.0 * radius / resolution.max(1) as f32;
            let centre = camera.eye() + middle * forward - whole.origin;
            let along = |axis: Vec3| (centre.dot(axis) / texel).round() * texel * axis;
            Face {
                origin: whole.origin + along(whole.right) + along(whole.up),
                rays: Rays::Parallel {
                    half_width: radius,
                    half_height: radius,
                },
                ..whole
            }
        };
        let faces = (0..CASCADES).map(of_part).collect();
        let maps = Self::of_faces(cpu, casters, faces, resolution)?;
        Ok(Self {
            cascades: Some(Splits {
                eye: camera.eye(),
                forward,
                ends,
            }),
            ..maps
        })
    }

    fn of_faces(
        cpu: &Cpu,
        casters: &Casters<Host>,
        faces: Vec<Face>,
        resolution: u32,
    ) -> Result<Self, ShadowMapError> {
        check_size(faces.len(), resolution)?;
        let texels = (resolution as usize).pow(2);
        let mut one = vec![0.0; texels];
        let mut depth = Vec::with_capacity(faces.len() * texels);
        let mut ranges = Vec::new();
        for face in &faces {
            let masked = casters.masks_on_host();
            render_face(cpu, face, casters.triangles(), masked, resolution, &mut one);
            let seen = one.iter().filter(|depth| **depth < EMPTY);
            let (first, last) = seen.fold((f32::INFINITY, 0.0_f32), |(first, last), depth| {
                (first.min(*depth), last.max(*depth))
            });
            let step = (last - first) / f32::from(NOTHING - 1);
            // If all depths are equal, the step is their rounding.
            let step = step.max(f32::EPSILON * last);
            depth.extend(one.iter().map(|depth| match *depth {
                EMPTY => NOTHING,
                // Rounding may push the last depth beyond the largest number.
                depth => (((depth - first) / step).ceil() as u16).min(NOTHING - 1),
            }));
            ranges.push([first, step]);
        }
        Ok(Self {
            faces,
            resolution,
            depth,
            ranges,
            cascades: None,
        })
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> u64 {
        2 * self.depth.len() as u64
    }

    /// Shadows on surfaces: the lit share of the `width × width` texels around a point. The
    /// point is lifted along its normal by half of that width plus one texel, as for
    /// precomputed shadows. Even widths count as the next odd one.
    ///
    /// Texels beyond the border of a picture repeat those at the border; points outside of all
    /// pictures are lit.
    pub fn filtered(&self, width: u32) -> FilteredMaps<'_> {
        FilteredMaps {
            maps: self,
            half: i64::from(width / 2),
        }
    }

    /// The pictures that may show a point, and the index of the first of them.
    fn pictures(&self, point: Vec3) -> (&[Face], usize) {
        let Some(splits) = &self.cascades else {
            return (&self.faces, 0);
        };
        let along = (point - splits.eye).dot(splits.forward);
        let first = splits.ends.iter().position(|end| along <= *end);
        let first = first.unwrap_or(CASCADES - 1);
        (&self.faces[first..=first], first)
    }
}

/// The bounding sphere of the part of a view between two distances along its axis: the distance
/// of its centre along the axis, and its radius.
fn sphere(spread: f32, near: f32, far: f32) -> (f32, f32) {
    // The centre is equally far from the corners of the near end and of the far end.
    let middle = 0.5 * (near + far) * (1.0 + spread);
    if middle >= far {
        return (far, far * spread.sqrt());
    }
    (middle, (far - middle).hypot(far * spread.sqrt()))
}

/// Filtered shadows from [`Depth16Maps`].
#[derive(Debug, Clone, Copy)]
pub struct FilteredMaps<'a> {
    maps: &'a Depth16Maps,
    half: i64,
}

impl SurfaceShadow for FilteredMaps<'_> {
    fn visibility(&self, point: Vec3, normal: Vec3) -> Vec3 {
        let maps = self.maps;
        let (faces, first) = maps.pictures(point);
        let width = 2 * self.half + 1;
        let lift = texel_width(faces, maps.resolution, point) * (0.5 * width as f32 + 1.0);
        let Some(place) = locate(faces, maps.resolution, point + lift * normal) else {
            return Vec3::ONE;
        };
        let picture = first + place.face;
        let [nearest, step] = maps.ranges[picture];
        // Points at stored depths of less than this block the light.
        let depth = (place.depth - nearest) / step;
        let side = i64::from(maps.resolution);
        let clamped = |at: i64| at.clamp(0, side - 1) as usize;
        let [column, row] = place.texel.map(|at| at as i64);
        let mut lit = 0;
        for y in row - self.half..=row + self.half {
            let start = (picture * side as usize + clamped(y)) * side as usize;
            for x in column - self.half..=column + self.half {
                let stored = maps.depth[start + clamped(x)];
                lit += u32::from(stored == NOTHING || depth <= f32::from(stored));
            }
        }
        Vec3::splat(lit as f32 / (width * width) as f32)
    }
}

/// The width of a texel at a point, m; 0 behind the picture.
pub(super) fn texel_width(faces: &[Face], resolution: u32, point: Vec3) -> f32 {
    let v = point - faces[0].origin;
    let face = &faces[face_along(faces.len(), v)];
    let half = match face.rays {
        Rays::Parallel {
            half_width,
            half_height,
        } => half_width.max(half_height),
        Rays::Central { tan } => tan * v.dot(face.forward).max(0.0),
    };
    2.0 * half / resolution as f32
}

#[cfg(test)]
mod tests {
    use glam::Quat;
    use reference::random::Random;

    use super::*;
    use crate::scene::{Cone, Emission, Geometry, Mesh, Scene};
    use crate::shadow_map::RenderShadowMap;

    /// A square above a floor.
    fn geometry() -> Geometry {
        let square = |half: f32, y: f32| {
            [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
                .map(|(x, z)| Vec3::new(half * x, y, half * z))
        };
        let mesh = Mesh {
            positions: [square(1.0, 2.0), square(40.0, 0.0)].concat(),
            triangles: vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]],
            ..Mesh::default()
        };
        Geometry::new(&Scene::from(mesh)).unwrap()
    }

    fn camera(yaw: f32, eye: Vec3) -> Camera {
        Camera::new(eye, Quat::from_rotation_y(yaw), 1.0).unwrap()
    }

    const SIZE: [u32; 2] = [160, 90];

    fn sun() -> DirectionalEmitter {
        match Emitter::directional(Vec3::new(0.2, -1.0, 0.1), Vec3::ONE).unwrap() {
            Emitter::Directional(sun) => sun,
            Emitter::Point(_) => panic!("a sun is directional"),
        }
    }

    /// Where the middle of the shadow of the square is, and 1 m beside its rim.
    fn check(shadow: &dyn SurfaceShadow, offset: Vec3, half: f32) {
        let middle = shadow.visibility(offset, Vec3::Y).x;
        assert_eq!(middle, 0.0);
        for side in [Vec3::X, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Z] {
            let beside = offset + (half + 1.0) * side;
            assert_eq!(shadow.visibility(beside, Vec3::Y), Vec3::ONE, "{beside}");
        }
    }

    #[test]
    fn plain_maps_and_cascades_have_the_shadow_of_a_square_and_no_other() {
        let cpu = Cpu::new();
        let casters = Casters::upload(&cpu, &geometry()).unwrap();
        let cone = Cone {
            inner: 0.5,
            outer: 0.9,
        };
        let down = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        for (emission, above) in [
            (Emission::spot(down, cone, None).unwrap(), 6.0),
            (Emission::Isotropic, 4.0),
        ] {
            let at = Vec3::new(0.0, above, 0.0);
            let lamp = Emitter::point(at, Vec3::ONE, f32::INFINITY, emission).unwrap();
            let maps = Depth16Maps::new(&cpu, &casters, &lamp, 512).unwrap();
            let pictures = maps.bytes() / (2 * 512 * 512);
            assert!(pictures == 1 || pictures == 6);
            for width in [1, 3, 9] {
                let half = above / (above - 2.0);
                check(&maps.filtered(width), Vec3::ZERO, half);
            }
        }
        let sun = sun();
        let offset = 2.0 * Vec3::new(0.2, 0.0, 0.1);
        let plain = Emitter::Directional(sun);
        let plain = Depth16Maps::new(&cpu, &casters, &plain, 512).unwrap();
        check(&plain.filtered(3), offset, 1.0);
        let view = (&camera(0.3, Vec3::new(0.0, 1.0, 8.0)), SIZE, [0.5, 60.0]);
        let maps = Depth16Maps::cascades(&cpu, &casters, &sun, view, 256).unwrap();
        assert_eq!(maps.bytes(), 4 * 2 * 256 * 256);
        check(&maps.filtered(3), offset, 1.0);
    }

    #[test]
    fn every_point_of_a_part_of_the_view_is_in_its_cascade() {
        let cpu = Cpu::new();
        let casters = Casters::upload(&cpu, &geometry()).unwrap();
        let mut random = Random::new(1);
        for _ in 0..20 {
            let eye = Vec3::from_array(random.vector(20.0));
            let camera = camera(3.0 * random.unit(), eye);
            let [near, far] = [0.3, 5.0 + 50.0 * random.unit()];
            let view = (&camera, SIZE, [near, far]);
            let maps = Depth16Maps::cascades(&cpu, &casters, &sun(), view, 64).unwrap();
            let splits = maps.cascades.unwrap();
            assert!(splits.ends.is_sorted() && (splits.ends[3] / far - 1.0).abs() < 1e-5);
            for _ in 0..200 {
                let [x, y] = SIZE.map(|pixels| random.unit() * pixels as f32);
                let way = camera.direction(x, y, SIZE[0], SIZE[1]);
                let along = near + (far - near) * random.unit();
                let point = eye + along / way.dot(splits.forward) * way;
                let (faces, _) = maps.pictures(point);
                assert!(locate(faces, 64, point).is_some(), "{point}");
            }
        }
    }

    #[test]
    fn cascades_keep_their_size_and_move_by_whole_texels() {
        let cpu = Cpu::new();
        let casters = Casters::upload(&cpu, &geometry()).unwrap();
        let of = |yaw: f32, eye: Vec3| {
            let camera = camera(yaw, eye);
            let view = (&camera, SIZE, [0.5, 40.0]);
            Depth16Maps::cascades(&cpu, &casters, &sun(), view, 128).unwrap()
        };
        let first = of(0.0, Vec3::ZERO);
        let second = of(1.0, Vec3::new(3.3, 0.7, 2.1));
        for (a, b) in first.faces.iter().zip(&second.faces) {
            let half = |face: &Face| match face.rays {
                Rays::Parallel { half_width, .. } => half_width,
                Rays::Central { tan } => tan,
            };
            assert!((half(a) / half(b) - 1.0).abs() < 1e-5);
            let texel = 2.0 * half(a) / 128.0;
            for axis in [a.right, a.up] {
                let texels = (b.origin - a.origin).dot(axis) / texel;
                assert!((texels - texels.round()).abs() < 1e-2, "{texels}");
            }
        }
    }

    #[test]
    fn cascades_without_a_part_of_a_view_are_refused() {
        let cpu = Cpu::new();
        let casters = Casters::upload(&cpu, &geometry()).unwrap();
        let camera = camera(0.0, Vec3::ZERO);
        let of = |size: [u32; 2], distances: [f32; 2]| {
            Depth16Maps::cascades(&cpu, &casters, &sun(), (&camera, size, distances), 16)
        };
        for [near, far] in [
            [0.0, 1.0],
            [-1.0, 1.0],
            [1.0, 1.0],
            [2.0, 1.0],
            [f32::NAN, 1.0],
            [1.0, f32::NAN],
            [1.0, f32::INFINITY],
            [1e-13, 1.0],
            [1.0, 1e13],
        ] {
            let refused = of(SIZE, [near, far]).unwrap_err();
            let is_it = matches!(refused, ShadowMapError::CascadeDistances { .. });
            assert!(is_it, "{near} to {far}: {refused}");
        }
        for [width, height] in [[0, 90], [160, 0]] {
            let refused = of([width, height], [0.5, 40.0]).unwrap_err();
            assert_eq!(refused, ShadowMapError::ViewSize { width, height });
        }
        let widest = of([u32::MAX, 1], [1e-12, 1e12]).unwrap();
        let is_finite = |face: &Face| match face.rays {
            Rays::Parallel { half_width, .. } => half_width.is_finite() && face.origin.is_finite(),
            Rays::Central { .. } => false,
        };
        assert!(widest.faces.iter().all(is_finite));
    }

    /// Depths are rounded by a step at most, away from the light.
    #[test]
    fn depths_are_those_of_maps_to_a_step() {
        let cpu = Cpu::new();
        let casters = Casters::upload(&cpu, &geometry()).unwrap();
        let emission = Emission::Isotropic;
        let at = Vec3::new(0.3, 3.0, 0.2);
        let lamp = Emitter::point(at, Vec3::ONE, f32::INFINITY, emission).unwrap();
        let exact = cpu.shadow_map(&casters, &lamp, 33).unwrap();
        let maps = Depth16Maps::new(&cpu, &casters, &lamp, 33).unwrap();
        assert_eq!(maps.depth.len(), exact.depth().len());
        for (i, (small, depth)) in maps.depth.iter().zip(exact.depth()).enumerate() {
            let [first, step] = maps.ranges[i / (33 * 33)];
            match *depth {
                EMPTY => assert_eq!(*small, NOTHING),
                depth => {
                    let behind = first + f32::from(*small) * step - depth;
                    assert!((-1e-5 * depth..=1.001 * step + 1e-5 * depth).contains(&behind));
                }
            }
        }
        let refused = Depth16Maps::new(&cpu, &casters, &lamp, 0).unwrap_err();
        assert!(matches!(refused, ShadowMapError::Resolution { .. }));
    }
}
