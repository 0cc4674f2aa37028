//! Many eye rays at once.
//!
//! Rays are worked off in blocks of [`RAYS`]. Within a block every step is a loop over
//! arrays that the compiler turns into vector instructions, compiled for AVX-512, for AVX2
//! and for what every processor has, and chosen when the program runs. No step fuses a
//! multiplication with an addition, so that all of them give the bits of a ray by itself.
//!
//! What binds is arithmetic: two roots and a division in f64 for the angles of a ray, three
//! divisions in f32 for its positions. The voxel along φ is looked up ray by ray: one guess,
//! three cross products and a division in f64.

use std::sync::LazyLock;

use glam::Vec2;
use pulp::{Arch, Simd, WithSimd};

use crate::{Angle, EyeRay, Lattice, Phi};

/// Rays of a block: a few vectors of any processor, so that the loops of a block overlap, and
/// little enough for the first-level cache.
pub const RAYS: usize = 64;

/// The best instructions that this processor has: asked once.
pub(crate) fn arch() -> Arch {
    static ARCH: LazyLock<Arch> = LazyLock::new(Arch::new);
    *ARCH
}

type Lanes<T> = [T; RAYS];

/// Up to [`RAYS`] eye rays, each up to the first surface, and where they are in a
/// [`Lattice`]: [`Lattice::locate_rays`] fills it.
///
/// From [`RayBlock::len`] on there are no rays, but places for them up to [`RAYS`]. Asked about
/// one of these, functions give what earlier rays have left there, or zeros: nothing to rely on.
#[derive(Debug, Clone)]
pub struct RayBlock {
    len: usize,
    rays: Lanes<[f32; 4]>,
    /// The vectors of both angles.
    alpha: [Lanes<f32>; 2],
    theta: [Lanes<f32>; 2],
    alpha_positions: Lanes<f32>,
    theta_positions: Lanes<f32>,
    /// φ of the surface, and the cell of the first guess of its voxel.
    phi: [Lanes<f32>; 2],
    cells: Lanes<u32>,
    ends: Lanes<f32>,
}

impl Default for RayBlock {
    /// No ray.
    fn default() -> Self {
        let zero = [0.0; RAYS];
        Self {
            len: 0,
            rays: [[0.0; 4]; RAYS],
            alpha: [zero; 2],
            theta: [zero; 2],
            alpha_positions: zero,
            theta_positions: zero,
            phi: [zero; 2],
            cells: [0; RAYS],
            ends: zero,
        }
    }
}

impl RayBlock {
    /// How many rays there are.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The coordinates of a ray: [`Space::ray`](crate::Space::ray) of its direction.
    ///
    /// # Panics
    /// If `ray` is not below [`RAYS`], as all of these.
    #[inline]
    pub fn ray(&self, ray: usize) -> EyeRay {
        let vector = |[x, y]: &[Lanes<f32>; 2]| Angle::of(Vec2::new(x[ray], y[ray]));
        EyeRay {
            alpha: vector(&self.alpha),
            theta: vector(&self.theta),
        }
    }

    /// The distance of its surface, metres; 0 for what was less or NaN.
    #[inline]
    pub fn surface(&self, ray: usize) -> f32 {
        self.rays[ray][3]
    }

    /// Its [`Lattice::alpha_position`].
    #[inline]
    pub fn alpha_position(&self, ray: usize) -> f32 {
        self.alpha_positions[ray]
    }

    /// Its [`Lattice::theta_position`].
    #[inline]
    pub fn theta_position(&self, ray: usize) -> f32 {
        self.theta_positions[ray]
    }

    /// The [`Lattice::phi_position`] of its surface.
    #[inline]
    pub fn end(&self, ray: usize) -> f32 {
        self.ends[ray]
    }
}

impl Lattice {
    /// Finds where eye rays are, bit for bit as the functions of a single ray do, with vector
    /// instructions. A ray is a direction of any length and, as the fourth number,
    /// the distance to its first surface in metres (+∞ for the sky).
    ///
    /// ```
    /// use epipolar::{Lattice, Light, RayBlock, Resolution, Space, Spacing, ViewVolume};
    ///
    /// let space = Space::new(Light::point([2.0, 3.0, -6.0])?, [0.0, 1.7, 0.0])?;
    /// let view = ViewVolume::all_around(0.0, 40.0)?;
    /// let voxels = Resolution::new(256, 256, 128)?;
    /// let lattice = Lattice::new(space, &view, voxels, Spacing::Angle)?;
    ///
    /// let mut block = RayBlock::default();
    /// lattice.locate_rays(&[[0.1, 0.2, -1.0, 7.5]], &mut block);
    /// let ray = lattice.space().ray([0.1, 0.2, -1.0]);
    /// let surface = lattice.space().phi_along(&ray, 7.5);
    /// assert_eq!(block.alpha_position(0), lattice.alpha_position(ray.alpha));
    /// assert_eq!(block.end(0), lattice.phi_position(surface));
    /// # Ok::<(), epipolar::Error>(())
    /// ```
    ///
    /// # Panics
    /// If there are more than [`RAYS`] rays.
    pub fn locate_rays(&self, rays: &[[f32; 4]], block: &mut RayBlock) {
        self.locate_rays_on(arch(), rays, block);
    }

    pub(crate) fn locate_rays_on(&self, arch: Arch, rays: &[[f32; 4]], block: &mut RayBlock) {
        block.len = rays.len();
        block.rays[..rays.len()].copy_from_slice(rays);
        arch.dispatch(Located {
            lattice: self,
            block,
        });
        for i in 0..block.len {
            let pair = Vec2::new(block.phi[0][i], block.phi[1][i]);
            block.ends[i] = self.phi_position_in(block.cells[i] as usize, pair);
        }
    }
}

struct Located<'a> {
    lattice: &'a Lattice,
    block: &'a mut RayBlock,
}

impl WithSimd for Located<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { lattice, block } = self;
        let space = lattice.space();
        for i in 0..RAYS {
            let [x, y, z, surface] = block.rays[i];
            let [alpha, theta] = space.angles([x, y, z]);
            [block.alpha[0][i], block.alpha[1][i]] = alpha;
            [block.theta[0][i], block.theta[1][i]] = theta;
            block.rays[i][3] = surface.max(0.0);
        }
        for i in 0..RAYS {
            let alpha = Vec2::new(block.alpha[0][i], block.alpha[1][i]);
            block.alpha_positions[i] = lattice.alpha_position(Angle(alpha));
        }
        for i in 0..RAYS {
            let theta = Vec2::new(block.theta[0][i], block.theta[1][i]);
            block.theta_positions[i] = lattice.theta_position(Angle(theta));
        }
        // Whether the light is directional is a constant in each copy of the loop, so that it has
        // no branch.
        if space.is_directional() {
            ends::<true>(lattice, block);
        } else {
            ends::<false>(lattice, block);
        }
    }
}

/// φ of the surfaces.
#[inline(always)]
fn ends<const DIRECTIONAL: bool>(lattice: &Lattice, block: &mut RayBlock) {
    for i in 0..RAYS {
        let alpha = Vec2::new(block.alpha[0][i], block.alpha[1][i]);
        let distance = block.rays[i][3];
        let Phi(pair) = lattice.space().phi_of::<DIRECTIONAL>(alpha, distance);
        [block.phi[0][i], block.phi[1][i]] = pair.into();
        block.cells[i] = lattice.phi_cell(pair) as u32;
    }
}

/// The [`Lattice::blocked_from`] of all light rays of a plane from one on.
struct Blocked<'a> {
    lattice: &'a Lattice,
    units: &'a [Vec2],
    distances: &'a [f32],
    indices: &'a mut [u32],
}

impl WithSimd for Blocked<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        if self.lattice.space().is_directional() {
            self.fill::<true>();
        } else {
            self.fill::<false>();
        }
    }
}

impl Blocked<'_> {
    #[inline(always)]
    fn fill<const DIRECTIONAL: bool>(self) {
        let rays = self.units.iter().zip(self.distances);
        for (index, (unit, distance)) in self.indices.iter_mut().zip(rays) {
            *index = self.lattice.blocked::<DIRECTIONAL>(*unit, *distance);
        }
    }
}

impl Lattice {
    /// [`Lattice::blocked_from`] of light rays whose bits follow each other, from `first` on,
    /// with one distance each: the same indices, with vector instructions.
    ///
    /// What binds is arithmetic, mostly of the angle function.
    ///
    /// # Panics
    /// If there are not as many indices as distances, or fewer bits.
    pub fn blocked_from_each(&self, first: usize, distances: &[f32], indices: &mut [u32]) {
        self.blocked_from_each_on(arch(), first, distances, indices);
    }

    pub(crate) fn blocked_from_each_on(
        &self,
        arch: Arch,
        first: usize,
        distances: &[f32],
        indices: &mut [u32],
    ) {
        assert_eq!(distances.len(), indices.len(), "one index per distance");
        arch.dispatch(Blocked {
            lattice: self,
            units: self.units(first..first + distances.len()),
            distances,
            indices,
        });
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::{Light, Resolution, Space, Spacing, ViewVolume};

    /// All levels of instructions that this processor has.
    fn every_arch() -> Vec<Arch> {
        let mut all = vec![Arch::Scalar];
        #[cfg(target_arch = "x86_64")]
        {
            all.extend(pulp::x86::V3::try_new().map(Arch::V3));
            all.extend(pulp::x86::V4::try_new().map(Arch::V4));
        }
        all
    }

    const EYE: Vec3 = Vec3::new(0.2, 1.7, 0.4);

    /// In view, behind, next to the eye, far, parallel, with every spacing.
    fn lattices() -> Vec<Lattice> {
        let lights = [
            Light::point([1.0, 2.0, -5.0]),
            Light::point([0.3, 1.6, 6.0]),
            Light::point([0.2001, 1.7, 0.4]),
            Light::point([0.0, 3e4, -2e4]),
            Light::directional([0.1, -1.0, 0.3]),
            Light::directional([0.0, 0.0, 1.0]),
        ];
        let airlight = Spacing::Airlight { sigma_t: 0.2 };
        let spacings = [Spacing::Angle, Spacing::Distance, airlight];
        let view = ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [0.8, 0.45], 0.1, 30.0).unwrap();
        let voxels = Resolution::new(96, 80, 64).unwrap();
        lights
            .map(Result::unwrap)
            .into_iter()
            .flat_map(|light| spacings.map(|spacing| (light, spacing)))
            .map(|(light, spacing)| {
                let space = Space::new(light, EYE).unwrap();
                Lattice::new(space, &view, voxels, spacing).unwrap()
            })
            .collect()
    }

    /// Those of a picture, towards and away from what is on the axis, of any length, none.
    fn rays(lattice: &Lattice) -> Vec<[f32; 4]> {
        let mut rays = Vec::new();
        for i in 0..1000_u16 {
            let [x, y] = [i % 40, i / 40].map(|k| 0.04 * f32::from(k) - 0.5);
            rays.push([x, y, -1.0, 0.01 * f32::from(i)]);
        }
        let [axis, ..] = lattice.space().frame();
        let surfaces = [0.0, -1.0, 5.0, 1e18, f32::MAX, f32::INFINITY, f32::NAN];
        for scale in [1.0, -1.0, 1e-45, 1e-38, -1e-30, 3e38, 0.0, f32::NAN] {
            for surface in surfaces {
                for [x, y, z] in [axis, [0.3, -0.2, -1.0], [0.0, 0.0, 1.0]] {
                    rays.push([scale * x, scale * y, scale * z, surface]);
                }
            }
        }
        rays.push([f32::INFINITY, 0.0, 1.0, 2.0]);
        rays.push([0.0, f32::NAN, 1.0, 2.0]);
        rays
    }

    #[test]
    fn a_block_has_the_bits_of_its_rays_one_by_one_with_all_instructions() {
        let bits = |values: [f32; 8]| values.map(f32::to_bits);
        for lattice in lattices() {
            let space = lattice.space();
            for arch in every_arch() {
                let mut block = RayBlock::default();
                for rays in rays(&lattice).chunks(RAYS) {
                    lattice.locate_rays_on(arch, rays, &mut block);
                    assert_eq!(block.len(), rays.len());
                    for (i, [x, y, z, surface]) in rays.iter().enumerate() {
                        let ray = space.ray([*x, *y, *z]);
                        let surface = surface.max(0.0);
                        let positions = [
                            lattice.alpha_position(ray.alpha),
                            lattice.theta_position(ray.theta),
                            lattice.phi_position(space.phi_along(&ray, surface)),
                            surface,
                        ];
                        let found = [
                            block.alpha_position(i),
                            block.theta_position(i),
                            block.end(i),
                            block.surface(i),
                        ];
                        let all = |ray: EyeRay, [a, b, c, d]: [f32; 4]| {
                            let ([e, f], [g, h]) = (ray.alpha.vector(), ray.theta.vector());
                            bits([a, b, c, d, e, f, g, h])
                        };
                        let expected = all(ray, positions);
                        assert_eq!(all(block.ray(i), found), expected, "{:?}", rays[i]);
                    }
                }
            }
        }
        let empty = RayBlock::default();
        assert!(empty.is_empty());
    }

    #[test]
    fn blockers_of_a_plane_are_those_of_its_light_rays_one_by_one() {
        let mut distances: Vec<f32> = (0..57_u16).map(|i| 0.003 * f32::from(i * i)).collect();
        distances.extend([-2.0, -1e30, 1e30, f32::MAX, f32::INFINITY, f32::NAN, -0.0]);
        for lattice in lattices() {
            for arch in every_arch() {
                for (first, count) in [(0, 64), (3, 61), (32, 32), (10, 0)] {
                    let distances = &distances[64 - count..];
                    let mut found = vec![7; count];
                    lattice.blocked_from_each_on(arch, first, distances, &mut found);
                    for (i, distance) in distances.iter().enumerate() {
                        assert_eq!(found[i], lattice.blocked_from(first + i, *distance));
                    }
                }
            }
        }
    }

    #[test]
    fn a_guess_gives_what_a_search_gives() {
        for lattice in lattices() {
            let mut pairs = vec![Vec2::ZERO, Vec2::NAN, Vec2::NEG_X, Vec2::X, Vec2::Y];
            pairs.push(Vec2::new(f32::INFINITY, 1.0));
            pairs.push(Vec2::new(0.0, f32::INFINITY));
            for bound in lattice.bounds() {
                let [w, q] = *bound;
                for scale in [1e-20, 1.0, 3.0, 1e20] {
                    for w in [w.next_down(), w, w.next_up()] {
                        for q in [q.next_down(), q, q.next_up()] {
                            pairs.push(scale * Vec2::new(w, q.max(0.0)));
                        }
                    }
                }
            }
            for i in 0..=2000_u16 {
                let (sin, cos) = (f32::from(i) * std::f32::consts::PI / 2000.0).sin_cos();
                pairs.push(Vec2::new(cos, sin.max(0.0)));
                pairs.push(Vec2::new(1.0, 0.02 * f32::from(i)));
            }
            for pair in pairs {
                let expected = lattice.search_phi(pair).to_bits();
                let found = lattice.phi_position(Phi(pair)).to_bits();
                assert_eq!(found, expected, "{pair}");
                // Whatever the guess.
                for cell in [0, 100, 255] {
                    let found = lattice.phi_position_in(cell, pair).to_bits();
                    assert_eq!(found, expected, "{pair} from {cell}");
                }
            }
        }
    }
}
