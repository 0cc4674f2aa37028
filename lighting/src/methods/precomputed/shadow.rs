//! The precomputed shadows of one light.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use gpu_backend::{Backend, Cpu, Host, Memory};
use shadow_dag::{
    Builder, Error, Form, Holes, LightGrids, LightSpace, ResidentDag, Resolution, SetBake,
    ShadowDag, ShadowSet, Slices, Surfaces, Watertightness,
};

use super::space::light_grids;
use crate::scene::{AlphaMode, Caster, Geometry, Sampler};
use crate::shadow_map::Masked;
use crate::visibility::product;
use crate::{Emitter, LightPath, LitInterval, VisibilitySource};

/// Why some grids are not the shadows of a light.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakedError {
    /// There are neither one nor six grids.
    #[error("{0} grids for one light, expected 1 or 6")]
    Grids(usize),
    /// A grid, given by its index, does not say where it is in the world.
    #[error("grid {0} does not say where in the world it is")]
    NoLight(usize),
    /// A grid has another resolution than the first one.
    #[error("grid {grid} has {side} voxels along each axis, expected {expected} as in grid 0")]
    Resolutions {
        /// Index of the grid.
        grid: usize,
        /// Voxels along each of its axes.
        side: u32,
        /// Voxels along each axis of the first.
        expected: u32,
    },
    /// There is not enough memory.
    #[error(transparent)]
    Memory(#[from] Error),
}

/// The precomputed voxelized shadows that a scene casts from one light, in the memory `M`.
///
/// There is one grid where a single picture contains all casters: for a sun, a spotlight of up
/// to 75° half angle, and a light far enough outside of the scene. Otherwise there are six, see
/// [`light_spaces`](super::light_spaces). All of them are in one buffer.
///
/// In the memory of the CPU they are a [`VisibilitySource`]; [`BakedShadow::upload`] copies
/// them to a GPU, where they are one too. A ray takes one step for each homogeneous volume on
/// its way. The ends of lit parts on a GPU differ from those on the CPU as `shadow_dag::gpu`
/// says, and where grids meet by the rounding of an f32.
#[derive(Debug)]
pub struct BakedShadow<M: Memory = Host> {
    grids: Vec<ResidentDag<M>>,
    /// See [`ShadowSet::bias`].
    bias: f32,
}

impl<M: Memory> Clone for BakedShadow<M> {
    /// Copies share the buffer.
    fn clone(&self) -> Self {
        Self {
            grids: self.grids.clone(),
            bias: self.bias,
        }
    }
}

/// The triangles of a scene as shadow casters, for any number of lights: solid ones, and masked
/// ones with their holes. Triangles that cast no shadow and see-through ones are left out.
///
/// Dynamic triangles are included: pass [`Geometry::static_part`] if something moves.
///
/// [`Surfaces::watertightness`] tells which parts of the scene are closed. Their inside
/// compresses well. All other parts, and parts with masks, cast their shadows as open surfaces.
///
/// # Errors
/// None that a checked scene could cause.
pub fn surfaces(geometry: &Geometry) -> Result<Surfaces<'_>, Error> {
    let masked = Masked::new(geometry);
    let order = masked.order(geometry);
    let count = order.as_ref().map_or(geometry.triangles().len(), Vec::len) as u32;
    let indices: Vec<[u32; 3]> = (0..count)
        .map(|triangle| [3 * triangle, 3 * triangle + 1, 3 * triangle + 2])
        .collect();
    let surfaces = match order {
        None => {
            let corners: &[[f32; 3]] = bytemuck::cast_slice(geometry.triangles().as_flattened());
            Surfaces::new(corners, indices)?
        }
        Some(order) => {
            let corners = order.as_flattened().iter().map(|corner| corner.to_array());
            Surfaces::new(corners.collect::<Vec<_>>(), indices)?
        }
    };
    let solid = count - masked.len() as u32;
    if solid == count {
        return Ok(surfaces);
    }
    let with_holes: Vec<u32> = (solid..count).collect();
    Ok(surfaces.with_holes(&with_holes, Arc::new(MaskHoles { masked, solid })))
}

/// The holes of masked triangles, which follow the solid ones.
#[derive(Debug)]
struct MaskHoles {
    masked: Masked,
    solid: u32,
}

impl Holes for MaskHoles {
    fn is_hole(&self, triangle: u32, u: f64, v: f64) -> bool {
        let index = (triangle - self.solid) as usize;
        !self.masked.blocks(index, u, v)
    }

    fn describe(&self, word: &mut dyn FnMut(u64)) {
        let mut described = BTreeSet::new();
        for index in 0..self.masked.len() {
            let Caster::Masked(coating) = self.masked.caster(index) else {
                continue;
            };
            let mut number = |value: f32| word(u64::from(value.to_bits()));
            for (uv, color) in coating.texture_coordinates().iter().zip(coating.colors()) {
                number(uv.x);
                number(uv.y);
                number(color.w);
            }
            number(coating.base_opacity());
            if let AlphaMode::Mask { cutoff } = coating.mode() {
                number(cutoff);
            }
            let Some(texture) = coating.texture() else {
                continue;
            };
            let Some(alpha) = texture.alpha() else {
                continue;
            };
            if described.insert(alpha.as_ptr()) {
                alpha.iter().for_each(|texel| number(*texel));
            }
            let Sampler { wrap, filter } = texture.sampler();
            word(u64::from(texture.width()));
            word(wrap[0] as u64 | (wrap[1] as u64) << 8 | (filter as u64) << 16);
        }
    }
}

/// A bake of these grids in a scene, with nothing done yet. The grids are those of
/// [`light_grids`], for one light each. The bake can be watched, stopped, saved, resumed and
/// divided; [`BakedShadow::of_set`] takes the result.
///
/// Dynamic triangles are included: pass [`Geometry::static_part`] if something moves.
///
/// # Errors
/// Those of [`SetBake::new`].
pub fn bake(
    geometry: &Geometry,
    lights: Vec<LightGrids>,
    builder: Builder,
) -> Result<SetBake<'_>, Error> {
    SetBake::new(builder, surfaces(geometry)?, lights)
}

impl BakedShadow {
    /// Bakes the shadows of a scene from `emitter` into grids of `resolution` voxels along each
    /// axis. Also returns how much of the scene is closed.
    ///
    /// [`bake`] does the same in steps that can be interrupted, and for several lights.
    ///
    /// Dynamic triangles are included: pass [`Geometry::static_part`] if something moves.
    ///
    /// # Errors
    /// Those of [`light_spaces`](super::light_spaces), and [`Error::TooManyNodes`].
    pub fn bake(
        cpu: &Cpu,
        geometry: &Geometry,
        emitter: &Emitter,
        resolution: Resolution,
        builder: Builder,
    ) -> Result<(Self, Watertightness), Error> {
        let grids = light_grids(geometry, emitter, resolution)?;
        let mut bake = bake(geometry, vec![grids], builder)?;
        let watertightness = bake.watertightness();
        bake.advance(cpu, usize::MAX, &AtomicBool::new(false), |_| {})?;
        let grids = bake.finish()?.into_lights().concat();
        let bias = LightGrids::BIAS;
        Ok((Self::resident(&grids, bias)?, watertightness))
    }

    fn resident<B: AsRef<[u8]>>(grids: &[ShadowDag<B>], bias: f32) -> Result<Self, Error> {
        let grids = ShadowDag::upload_all(grids, &Cpu::single_threaded())?;
        Ok(Self { grids, bias })
    }

    /// The shadows of a light from copies of its grids. The grids may be in any order, but they
    /// [fit](BakedShadow::fits) a light only in that of [`light_spaces`](super::light_spaces).
    ///
    /// # Errors
    /// [`BakedError`] if there are neither one nor six grids, if one of them does not know the
    /// space of its light, or if their resolutions differ.
    pub fn new<B: AsRef<[u8]>>(grids: &[ShadowDag<B>]) -> Result<Self, BakedError> {
        if !matches!(grids.len(), 1 | 6) {
            return Err(BakedError::Grids(grids.len()));
        }
        if let Some(grid) = grids.iter().position(|grid| grid.light().is_none()) {
            return Err(BakedError::NoLight(grid));
        }
        let expected = grids[0].resolution().side();
        let mut sides = (grids.iter().map(|grid| grid.resolution().side())).enumerate();
        match sides.find(|(_, side)| *side != expected) {
            Some((grid, side)) => Err(BakedError::Resolutions {
                grid,
                side,
                expected,
            }),
            None => Ok(Self::resident(grids, LightGrids::BIAS)?),
        }
    }

    /// The shadows of each light of a set: of a file that
    /// [`ShadowSet::from_bytes`] read, or of a finished [`bake`].
    ///
    /// # Errors
    /// As for [`BakedShadow::new`].
    pub fn of_set<B: AsRef<[u8]>>(set: &ShadowSet<B>) -> Result<Vec<Self>, BakedError> {
        let lights = set.lights().enumerate();
        lights
            .map(|(light, grids)| {
                let bias = set.bias(light);
                Self::new(grids).map(|shadow| Self { bias, ..shadow })
            })
            .collect()
    }

    /// The file of these shadows alone, see [`ShadowSet::write`].
    pub fn to_bytes(&self) -> Vec<u8> {
        let grids = self.grids.iter().map(ShadowDag::borrowed).collect();
        // A light has grids, and a bias that was checked.
        let set = ShadowSet::new(vec![grids]).ok();
        let set = set.and_then(|set| set.with_biases(vec![self.bias]).ok());
        set.map_or(Vec::new(), |set| set.to_bytes())
    }

    /// The same shadows with their nodes in another form.
    ///
    /// # Errors
    /// [`Error::TooManyNodes`] if the plain form is too long for its
    /// references.
    pub fn to_form(&self, form: Form) -> Result<Self, Error> {
        if self.grids.iter().all(|grid| grid.form() == form) {
            return Ok(self.clone());
        }
        let grids = self.grids.iter().map(|grid| grid.to_form(form));
        Self::resident(&grids.collect::<Result<Vec<_>, _>>()?, self.bias)
    }

    /// Copies the shadows to the memory of a backend, in the form that is
    /// [walked best](Form::suitable) there.
    ///
    /// # Errors
    /// [`Error::TooManyNodes`], and [`gpu_backend::Error::TooLarge`] if they do
    /// not fit.
    pub fn upload<B: Backend>(&self, backend: &B) -> Result<BakedShadow<B::Memory>, Error> {
        let suitable = self.to_form(Form::suitable::<B::Memory>())?;
        let grids = ShadowDag::upload_all(&suitable.grids, backend)?;
        Ok(BakedShadow {
            grids,
            bias: self.bias,
        })
    }
}

/// The precomputed shadows of several lights in one buffer: what a pass of [many
/// lights](crate::methods::many_lights) asks on a GPU.
#[derive(Debug)]
pub struct BakedShadows<M: Memory> {
    lights: Vec<BakedShadow<M>>,
}

impl<M: Memory> BakedShadows<M> {
    /// Copies the shadows of a few lights to the memory of a backend, in the form that is
    /// [walked best](Form::suitable) there. They are numbered in this order.
    ///
    /// # Errors
    /// As for [`BakedShadow::upload`], of all of them together.
    pub fn upload<B: Backend<Memory = M>>(
        shadows: &[BakedShadow],
        backend: &B,
    ) -> Result<Self, Error> {
        let suitable = shadows
            .iter()
            .map(|shadow| shadow.to_form(Form::suitable::<M>()))
            .collect::<Result<Vec<_>, _>>()?;
        let grids: Vec<_> = (suitable.iter())
            .flat_map(|shadow| shadow.grids.iter().cloned())
            .collect();
        let mut grids = ShadowDag::upload_all(&grids, backend)?.into_iter();
        let lights = suitable.iter().map(|shadow| BakedShadow {
            grids: grids.by_ref().take(shadow.grids.len()).collect(),
            bias: shadow.bias,
        });
        Ok(Self {
            lights: lights.collect(),
        })
    }

    /// The shadows of many lights in as few buffers as hold them: of as many lights as fit
    /// into `most` bytes, then of the next ones. A light that does not fit has a buffer of
    /// its own.
    ///
    /// # Errors
    /// As for [`BakedShadows::upload`].
    pub fn upload_in_parts<B: Backend<Memory = M>>(
        shadows: &[BakedShadow],
        backend: &B,
        most: u64,
    ) -> Result<Vec<Self>, Error> {
        let mut parts = Vec::new();
        let mut some: Vec<BakedShadow> = Vec::new();
        let mut filled = 0;
        for shadow in shadows {
            let suitable = shadow.to_form(Form::suitable::<M>())?;
            if !some.is_empty() && filled + suitable.bytes() > most {
                parts.push(Self::upload(&some, backend)?);
                some.clear();
                filled = 0;
            }
            filled += suitable.bytes();
            some.push(suitable);
        }
        if !some.is_empty() {
            parts.push(Self::upload(&some, backend)?);
        }
        Ok(parts)
    }

    /// The shadows of each light.
    pub fn lights(&self) -> &[BakedShadow<M>] {
        &self.lights
    }

    /// Bytes of the buffer that holds them.
    pub fn bytes(&self) -> u64 {
        self.lights.first().map_or(0, BakedShadow::bytes)
    }
}

impl<M: Memory> BakedShadow<M> {
    /// The grids.
    pub fn grids(&self) -> &[ResidentDag<M>] {
        &self.grids
    }

    /// How far a point on a surface is moved along its normal beyond half a filter's
    /// width before it is asked about, in voxels.
    pub fn bias(&self) -> f32 {
        self.bias
    }

    /// Bytes of the buffer that holds them.
    pub fn bytes(&self) -> u64 {
        self.grids.first().map_or(0, ResidentDag::buffer_bytes)
    }

    /// True if the grids lie where those of a light do: the
    /// [`light_spaces`](super::light_spaces) of the emitter, at their resolution, are
    /// theirs, in the same order and to rounding; slices of a point light may also
    /// begin nearer and end farther away. Whether the scene has changed within its bounds since it was
    /// baked, nothing tells.
    pub fn fits(&self, spaces: &[LightSpace]) -> bool {
        let same = |(grid, space): (&ResidentDag<M>, &LightSpace)| {
            grid.light().is_some_and(|light| alike(light, space))
        };
        self.grids.len() == spaces.len() && self.grids.iter().zip(spaces).all(same)
    }
}

/// Equal to rounding, or `a` has slices for more depths than `b`.
fn alike(a: &LightSpace, b: &LightSpace) -> bool {
    let (m, n) = (a.matrix().to_cols_array(), b.matrix().to_cols_array());
    let largest = m.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let close = m
        .iter()
        .zip(&n)
        .all(|(x, y)| (x - y).abs() <= 1e-6 * largest);
    close
        && match (a.slices(), b.slices()) {
            (Slices::Linear, Slices::Linear) => true,
            (Slices::Logarithmic(grid), Slices::Logarithmic(light)) => {
                grid.near() <= light.near() * (1.0 + 1e-6)
                    && grid.far() >= light.far() * (1.0 - 1e-6)
            }
            _ => false,
        }
}

impl VisibilitySource for BakedShadow {
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
