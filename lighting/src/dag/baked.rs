//! The baked shadows of one light.

use std::fmt;

use glam::Vec3;
use gpu_backend::{Backend, Cpu};
use shadow_dag::{
    Builder, Error, FileError, FilterSize, Form, LightSpace, Mesh, Resolution, ShadowDag, Soundness,
};

use super::space::light_spaces;
use crate::scene::Geometry;
use crate::visibility::{SurfaceShadow, product};
use crate::{Emitter, LightPath, LitInterval, VisibilitySource};

/// Why shadows could not be put together from files.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BakedError {
    /// A light has one grid, or six.
    #[error("{0} grids for one light, expected 1 or 6")]
    Grids(usize),
    /// A grid that does not say where in the world it is.
    #[error("grid {0} does not say where in the world it is")]
    NoLight(usize),
    /// A grid of another resolution than the first.
    #[error("grid {grid} has {side} voxels along each axis, expected {expected} as in grid 0")]
    Resolutions {
        /// Which one, from 0.
        grid: usize,
        /// Voxels along each of its axes.
        side: u32,
        /// Voxels along each axis of the first.
        expected: u32,
    },
    /// Bytes that are no grid.
    #[error("grid {grid}: {error}")]
    File {
        /// Which one, from 0.
        grid: usize,
        /// Why not.
        error: FileError,
    },
}

/// The shadows that all of a scene casts from one light, baked.
///
/// One grid where a single picture holds all casters: for a sun, a spotlight of
/// up to 75° half angle and a light far enough outside of the scene; six
/// otherwise, see [`light_spaces`]. `B` is who owns their bytes.
#[derive(Debug, Clone)]
pub struct BakedShadow<B = Vec<u8>> {
    grids: Vec<ShadowDag<B>>,
}

/// A backend that can hold baked shadows, as a source that it gathers.
pub trait HoldShadow: Backend {
    /// The shadows in its memory.
    type Shadow: fmt::Debug;

    /// Copies shadows to the backend: as plain nodes, which are the quickest
    /// to walk, to the CPU, packed to a GPU.
    ///
    /// # Errors
    /// [`Error::TooManyNodes`], and [`gpu_backend::Error::TooLarge`] if they do
    /// not fit.
    fn hold<B: AsRef<[u8]>>(&self, shadow: &BakedShadow<B>) -> Result<Self::Shadow, Error>;
}

impl HoldShadow for Cpu {
    type Shadow = BakedShadow;

    fn hold<B: AsRef<[u8]>>(&self, shadow: &BakedShadow<B>) -> Result<BakedShadow, Error> {
        shadow.to_form(Form::Plain)
    }
}

/// The triangles of a scene as shadow casters for one grid of a light.
///
/// Which parts of the scene are closed, [`Mesh::soundness`] tells: the inside of
/// those compresses well. All others cast their shadows as open surfaces.
///
/// # Errors
/// None that a checked scene could cause.
pub fn casters(
    geometry: &Geometry,
    space: LightSpace,
    resolution: Resolution,
) -> Result<Mesh, Error> {
    let corners = geometry.triangles().as_flattened();
    let indices: Vec<[u32; 3]> = (0..geometry.triangles().len() as u32)
        .map(|triangle| [3 * triangle, 3 * triangle + 1, 3 * triangle + 2])
        .collect();
    Mesh::new(resolution, space, corners, &indices)
}

impl BakedShadow {
    /// Bakes the shadows of a scene from `emitter` into grids of `resolution`
    /// voxels along each axis, and tells how much of the scene is closed.
    ///
    /// A [`shadow_dag::Bake`] of the [`casters`] of each of the [`light_spaces`]
    /// does the same with breaks.
    ///
    /// # Errors
    /// Those of [`light_spaces`], and [`Error::TooManyNodes`].
    pub fn bake(
        cpu: &Cpu,
        geometry: &Geometry,
        emitter: &Emitter,
        resolution: Resolution,
        builder: Builder,
    ) -> Result<(Self, Soundness), Error> {
        let mut grids = Vec::new();
        let mut soundness = Soundness::default();
        for space in light_spaces(geometry, emitter, resolution)? {
            let casters = casters(geometry, space, resolution)?;
            soundness = casters.soundness();
            grids.push(builder.bake(cpu, &casters)?);
        }
        Ok((Self { grids }, soundness))
    }
}

impl<B: AsRef<[u8]>> BakedShadow<B> {
    /// The shadows of a light from its grids. They answer in any order, but only
    /// in that of [`light_spaces`] do they [fit](BakedShadow::fits) a light.
    ///
    /// # Errors
    /// [`BakedError`] if there are not one or six of them, one does not know
    /// the space of its light, or their resolutions differ.
    pub fn new(grids: Vec<ShadowDag<B>>) -> Result<Self, BakedError> {
        if !matches!(grids.len(), 1 | 6) {
            return Err(BakedError::Grids(grids.len()));
        }
        if let Some(grid) = grids.iter().position(|grid| grid.light().is_none()) {
            return Err(BakedError::NoLight(grid));
        }
        let expected = grids[0].resolution().side();
        let mut sides = grids
            .iter()
            .map(|grid| grid.resolution().side())
            .enumerate();
        match sides.find(|(_, side)| *side != expected) {
            Some((grid, side)) => Err(BakedError::Resolutions {
                grid,
                side,
                expected,
            }),
            None => Ok(Self { grids }),
        }
    }

    /// The grids.
    pub fn grids(&self) -> &[ShadowDag<B>] {
        &self.grids
    }

    /// The same shadows with their nodes in another form.
    ///
    /// # Errors
    /// [`Error::TooManyNodes`] if the plain form is too long for its
    /// references.
    pub fn to_form(&self, form: Form) -> Result<BakedShadow, Error> {
        let grids = self.grids.iter().map(|grid| grid.to_form(form));
        let grids = grids.collect::<Result<_, _>>()?;
        Ok(BakedShadow { grids })
    }

    /// Memory used, bytes.
    pub fn bytes(&self) -> usize {
        let bytes = self.grids.iter().map(|grid| {
            let sizes = grid.sizes();
            sizes.file + sizes.top_grid
        });
        bytes.sum()
    }

    /// True if the grids lie where those of a light do: the [`light_spaces`] of
    /// the emitter, at their resolution, are theirs, in the same order and to
    /// rounding. Whether the scene has changed within its bounds since it was
    /// baked, nothing tells.
    pub fn fits(&self, spaces: &[LightSpace]) -> bool {
        let same = |(grid, space): (&ShadowDag<B>, &LightSpace)| {
            grid.light().is_some_and(|light| alike(light, space))
        };
        self.grids.len() == spaces.len() && self.grids.iter().zip(spaces).all(same)
    }
}

/// Equal to rounding.
fn alike(a: &LightSpace, b: &LightSpace) -> bool {
    let (m, n) = (a.matrix().to_cols_array(), b.matrix().to_cols_array());
    let largest = m.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let close = m
        .iter()
        .zip(&n)
        .all(|(x, y)| (x - y).abs() <= 1e-6 * largest);
    // The depths of both ends and of the middle.
    let depths = [0.0, 0.5, 1.0].map(|t| (a.slices().depth(t), b.slices().depth(t)));
    close
        && depths
            .iter()
            .all(|(x, y)| (x - y).abs() <= 1e-6 * x.abs().max(y.abs()))
}

impl<B: AsRef<[u8]> + Sync> VisibilitySource for BakedShadow<B> {
    type Share = f32;

    fn lit_intervals(&self, path: &LightPath<'_>, lit: &mut Vec<LitInterval>) {
        let (span, ray) = (path.span(), path.ray());
        let ray = shadow_dag::Ray::new(ray.origin(), ray.direction(), span.end);
        // A ray of a path is finite and has a direction.
        let Ok(ray) = ray else { return };
        let mut parts = vec![LitInterval::unshadowed(span.start, span.end)];
        let (mut found, mut both) = (Vec::<LitInterval>::new(), Vec::new());
        // A grid calls lit what it does not see.
        for grid in &self.grids {
            let of_grid = grid.lit_intervals(&ray);
            let ends = of_grid.iter().map(|ends| ends.map(|end| end as f32));
            let of_grid = ends.filter(|[start, end]| start < end);
            found.clear();
            found.extend(of_grid.map(|[start, end]| LitInterval::unshadowed(start, end)));
            both.clear();
            product(&parts, &found, &mut both);
            std::mem::swap(&mut parts, &mut both);
        }
        lit.append(&mut parts);
    }
}

/// Filtered shadows on surfaces, from a [`BakedShadow`].
#[derive(Debug, Clone, Copy)]
pub struct FilteredShadow<'a, B> {
    shadow: &'a BakedShadow<B>,
    size: FilterSize,
    /// What is kept clear of the surface.
    clearance: FilterSize,
}

impl<B: AsRef<[u8]>> BakedShadow<B> {
    /// Shadows on surfaces, filtered over `size` texels.
    pub fn filtered(&self, size: FilterSize) -> FilteredShadow<'_, B> {
        FilteredShadow {
            shadow: self,
            size,
            // The widest filter has itself to do.
            clearance: FilterSize::new(size.width() + 2).unwrap_or(size),
        }
    }
}

impl<B: AsRef<[u8]> + Sync> SurfaceShadow for FilteredShadow<'_, B> {
    /// The lit share of the texels around the point, lifted off the surface
    /// along its normal so that it does not shadow itself: by half a filter
    /// width, as in the paper, and a voxel more, because point and surface are
    /// known to half a voxel each. Filters of one texel would be lifted by
    /// nothing otherwise.
    ///
    /// Where six grids meet, a window reaches over the rim of its grid into
    /// the next one's, which has the rest of it: shadowed shares add up.
    fn visibility(&self, point: Vec3, normal: Vec3) -> f32 {
        let mut shadowed = 0.0;
        for grid in &self.shadow.grids {
            let resolution = grid.resolution();
            let Some(space) = grid.light() else { continue };
            let Some(position) = space.voxel(resolution, point) else {
                continue;
            };
            let normal = space.normal(point, normal);
            let voxel = self.clearance.bias(position, normal);
            shadowed += 1.0 - grid.filter(voxel, self.size);
        }
        (1.0 - shadowed).max(0.0)
    }
}
