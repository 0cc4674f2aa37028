//! An environment and its halo, in the memory of a backend.

use airlight::point_spread::{Table, spread};
use glam::Vec3;
use gpu_backend::{Backend, Cpu, Host, Memory};

use super::grid::Grid;
use super::{Environment, EnvironmentError};
use crate::Ray;
use crate::scene::{Medium, PhaseFunction};

/// Number of depths of fog for which halos are computed where the fog is in a box. At worst the
/// halo varies like `T ln T`; between levels, which are squares of equal steps, linear
/// interpolation is within 1 %.
const LEVELS: usize = 8;

/// The largest grids of halos: for one depth, and for [`LEVELS`] depths.
const ONE_HALO: (usize, usize) = (256, 128);
const MANY_HALOS: (usize, usize) = (128, 64);

/// The patches that light surfaces, 15 degrees along each side.
pub(super) const PATCHES: Grid = Grid {
    width: 24,
    height: 12,
};

/// An environment behind a medium, in the memory of a backend.
///
/// It holds the picture, its halos for one depth of fog, or for eight depths if the fog is in a
/// box, and patches that represent it as a source of light.
#[derive(Debug)]
pub struct EnvironmentMap<M: Memory> {
    pub(super) medium: Medium,
    /// The length of the way through fog without bounds; `None` if a box defines it or there is
    /// no fog.
    pub(super) distance: Option<f32>,
    /// The length for which the last halo was computed.
    pub(super) longest: f32,
    pub(super) levels: usize,
    pub(super) sky_grid: Grid,
    pub(super) sky: M::Buffer<[f32; 4]>,
    pub(super) halo_grid: Grid,
    /// `σ_s/σ_t ∫ N L dω`, one level after the other.
    pub(super) halos: M::Buffer<[f32; 4]>,
    /// For each patch: `∫ ω dω` and the angular extent, its radiance, and its halo on all
    /// levels.
    pub(super) patches: M::Buffer<[f32; 4]>,
}

impl<M: Memory> EnvironmentMap<M> {
    /// What is seen of an environment from inside a medium or through it; `None` is a vacuum.
    ///
    /// The halos take a fraction of a second, once for each different extinction among the
    /// channels. A medium that scatters nothing has none.
    ///
    /// # Errors
    /// [`EnvironmentError::NoDistance`] in fog without bounds,
    /// [`EnvironmentError::UnusedDistance`] elsewhere,
    /// [`EnvironmentError::Backend`] if it does not fit into memory.
    pub fn new<B: Backend<Memory = M>>(
        backend: &B,
        environment: &Environment,
        medium: Option<&Medium>,
    ) -> Result<Self, EnvironmentError> {
        let unbounded = medium.is_some_and(|medium| medium.bounds().is_none());
        let distance = match (environment.distance, unbounded) {
            (None, true) => return Err(EnvironmentError::NoDistance),
            (Some(_), false) => return Err(EnvironmentError::UnusedDistance),
            (distance, _) => distance,
        };
        let vacuum = Medium::new(Vec3::ZERO, Vec3::ZERO, PhaseFunction::Isotropic)
            .expect("nothing is a medium");
        let medium = medium.copied().unwrap_or(vacuum);
        let sky_grid = Grid {
            width: environment.width,
            height: environment.height,
        };
        let texels = &environment.texels;
        let (levels, longest, (width, height)) = match (medium.bounds(), distance) {
            (Some(bounds), _) if !medium.scatters_nothing() => {
                (LEVELS, bounds.min().distance(bounds.max()), MANY_HALOS)
            }
            (_, Some(distance)) => (1, distance, ONE_HALO),
            _ => (1, 0.0, ONE_HALO),
        };
        let halo_grid = sky_grid.limited(width, height);
        let mut halos = Vec::with_capacity(levels * halo_grid.len());
        let source = sky_grid.resampled(texels, halo_grid);
        for level in 0..levels {
            halos.extend(halo(
                &medium,
                way_of(level, levels, longest),
                &source,
                halo_grid,
            )?);
        }
        let mut patches = Vec::with_capacity(PATCHES.len() * (2 + levels));
        for (index, radiance) in sky_grid.resampled(texels, PATCHES).iter().enumerate() {
            let weighted = PATCHES.weighted_direction(index);
            // About half the side of the patch, times its solid angle.
            let reach = 0.5 * weighted.length().powf(1.5);
            patches.push(weighted.extend(reach).to_array());
            patches.push(four(*radiance));
            let around = halo_grid.around(weighted.normalize());
            for level in halos.chunks_exact(halo_grid.len()) {
                patches.push(interpolated(level, &around).extend(0.0).to_array());
            }
        }
        let sky: Vec<[f32; 4]> = texels.iter().map(|texel| four(*texel)).collect();
        Ok(Self {
            medium,
            distance,
            longest,
            levels,
            sky_grid,
            sky: backend.upload(&sky)?,
            halo_grid,
            halos: backend.upload(&halos)?,
            patches: backend.upload(&patches)?,
        })
    }

    /// Memory that it takes, in bytes.
    pub fn bytes(&self) -> usize {
        let texels = self.sky_grid.len()
            + self.levels * self.halo_grid.len()
            + PATCHES.len() * (2 + self.levels);
        size_of::<[f32; 4]>() * texels
    }
}

impl EnvironmentMap<Host> {
    /// What a ray sees at its infinite end.
    pub(super) fn seen(&self, ray: &Ray) -> Vec3 {
        let direction = ray.direction();
        let way = self.way(ray.origin(), direction);
        let clear = interpolated(&self.sky, &self.sky_grid.around(direction));
        let around = self.halo_grid.around(direction);
        let of_level = |level| interpolated(&self.halos[level * self.halo_grid.len()..], &around);
        self.through(way, clear, of_level)
    }

    /// Irradiance of a surface whose sky is covered by fog alone.
    pub(super) fn irradiance(&self, position: Vec3, normal: Vec3) -> Vec3 {
        let patches = self.patches.chunks_exact(2 + self.levels);
        patches.fold(Vec3::ZERO, |sum, patch| {
            let weighted = three(patch[0]);
            let cos = above_horizon(normal.dot(weighted), patch[0][3]);
            if cos <= 0.0 {
                return sum;
            }
            let way = self.way(position, weighted.normalize());
            sum + cos * self.through(way, three(patch[1]), |level| three(patch[2 + level]))
        })
    }

    /// The length of the way through the fog from `start` on.
    fn way(&self, start: Vec3, direction: Vec3) -> f32 {
        match (self.distance, self.medium.bounds()) {
            (Some(distance), _) => distance,
            (None, None) => 0.0,
            (None, Some(_)) => self.medium.length_inside(start, direction, f32::INFINITY),
        }
    }

    /// Radiance behind fog: the attenuated clear radiance plus the halo, interpolated between
    /// two levels.
    fn through(&self, way: f32, clear: Vec3, halo: impl Fn(usize) -> Vec3) -> Vec3 {
        let depth = self.medium.sigma_t() * way;
        let last = self.levels - 1;
        let halo = if last == 0 {
            halo(0)
        } else {
            let x = (way / self.longest).min(1.0).sqrt() * last as f32;
            let first = (x as usize).min(last - 1);
            let (low, high) = (halo(first), halo(first + 1));
            low + (x - first as f32) * (high - low)
        };
        (-depth).exp() * (clear + depth * halo)
    }
}

/// `∫ max(0, n·ω) dω` over a patch, from `cos` = `∫ n·ω dω` and from `reach`, how far `n·ω`
/// deviates from its middle: `n·ω` is taken to be evenly distributed between the two ends.
fn above_horizon(cos: f32, reach: f32) -> f32 {
    if cos >= reach {
        cos
    } else {
        let above = (cos + reach).max(0.0);
        above * above / (4.0 * reach)
    }
}

/// The length of the way on a level; levels are squares of equal steps.
fn way_of(level: usize, levels: usize, longest: f32) -> f32 {
    match levels {
        1 => longest,
        _ => longest * (level as f32 / (levels - 1) as f32).powi(2),
    }
}

/// `σ_s/σ_t ∫ N L dω` behind so many metres of fog, for every channel.
fn halo(
    medium: &Medium,
    way: f32,
    source: &[[f32; 3]],
    grid: Grid,
) -> Result<Vec<[f32; 4]>, EnvironmentError> {
    let mut result = vec![[0.0; 4]; grid.len()];
    let (sigma_s, sigma_t) = (medium.sigma_s().to_array(), medium.sigma_t().to_array());
    let mut last: Option<(f32, Vec<[f32; 3]>)> = None;
    for channel in 0..3 {
        if sigma_s[channel] == 0.0 {
            continue;
        }
        let t = sigma_t[channel] * way;
        let blurred = match last.take() {
            Some((same, blurred)) if same == t => blurred,
            _ => spread(
                &Cpu::new(),
                &Table::new(t)?,
                source,
                grid.width,
                grid.height,
            )?,
        };
        let albedo = sigma_s[channel] / sigma_t[channel];
        for (result, blurred) in result.iter_mut().zip(&blurred) {
            result[channel] = albedo * blurred[channel];
        }
        last = Some((t, blurred));
    }
    Ok(result)
}

fn interpolated(texels: &[[f32; 4]], around: &[(usize, f32); 4]) -> Vec3 {
    around.iter().fold(Vec3::ZERO, |sum, (texel, weight)| {
        sum + *weight * three(texels[*texel])
    })
}

fn three([r, g, b, _]: [f32; 4]) -> Vec3 {
    Vec3::new(r, g, b)
}

fn four([r, g, b]: [f32; 3]) -> [f32; 4] {
    [r, g, b, 0.0]
}
