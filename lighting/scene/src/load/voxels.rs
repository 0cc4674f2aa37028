//! Scenes of the grids of a NanoVDB or OpenVDB file, which are sparse there and dense
//! here.

use glam::{Affine3A, DMat3, DVec3, Vec3};

use super::limits::{Budget, Notes};
use super::{LoadError, LoadOptions, Loaded, printable};
use crate::{Bounds, DensityGrid, Interpolation, MAX_SAMPLES, Scene};

/// The name of the grid of densities, and those of one that emits, the first before the
/// others.
const DENSITY: &str = "density";
const EMISSION: [&str; 3] = ["emission", "flames", "flame"];

/// A grid of floats in a file.
pub(super) trait VoxelGrid {
    /// The format, as errors name it.
    const FORMAT: &'static str;

    /// The least and the greatest index of the voxels that are there; `None` if there are
    /// none.
    fn indices(&self) -> Option<[[i64; 3]; 2]>;

    /// From indices to the space of the file.
    fn placement(&self) -> Placement;

    /// The number outside of the voxels.
    fn background(&self) -> f32;

    /// Writes the numbers of what is not background in [`indices`](VoxelGrid::indices).
    fn fill(&self, dense: &mut Dense) -> Result<(), LoadError>;
}

/// A matrix and what is added behind it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placement {
    pub(super) turn: DMat3,
    pub(super) shift: DVec3,
}

impl Placement {
    /// Whether voxels of one are those of the other, but for rounding.
    fn is_that_of(&self, other: &Self) -> bool {
        const ROUNDING: f64 = 1e-6;
        let size = self.turn.to_cols_array().map(f64::abs);
        let size = size.into_iter().fold(0.0, f64::max);
        let turn = (self.turn - other.turn).to_cols_array().map(f64::abs);
        let shift = (self.shift - other.shift).abs().max_element();
        turn.into_iter().all(|step| step <= ROUNDING * size) && shift <= ROUNDING * size
    }
}

/// Numbers in a box, x fastest.
#[derive(Debug)]
pub(super) struct Dense {
    /// The first index along each axis, and how many there are.
    first: [i64; 3],
    counts: [usize; 3],
    /// What may be written, ends included.
    window: [[i64; 3]; 2],
    values: Vec<f32>,
}

impl Dense {
    /// The numbers of a grid in the box that begins at `first`, 0 outside of its voxels.
    pub(super) fn of(
        grid: &impl VoxelGrid,
        first: [i64; 3],
        resolution: [u32; 3],
    ) -> Result<Vec<f32>, LoadError> {
        let counts = resolution.map(|count| count as usize);
        let Some(window) = grid.indices() else {
            return Ok(vec![0.0; counts.iter().product()]);
        };
        let mut dense = Self {
            first,
            counts,
            window,
            values: vec![0.0; counts.iter().product()],
        };
        if grid.background() != 0.0 {
            dense.fill(window, grid.background());
        }
        grid.fill(&mut dense)?;
        Ok(dense.values)
    }

    /// Writes a number at all indices of a box, ends included.
    pub(super) fn fill(&mut self, [low, high]: [[i64; 3]; 2], value: f32) {
        self.write([low, high], |_| value);
    }

    /// Writes a leaf of 8³ numbers, z fastest, from this corner on.
    pub(super) fn leaf(&mut self, corner: [i64; 3], value: impl Fn(usize) -> f32) {
        self.write([corner, corner.map(|index| index + 7)], |[x, y, z]| {
            let [x, y, z] = [x, y, z].map(|index| (index & 7) as usize);
            value((x << 6) | (y << 3) | z)
        });
    }

    fn write(&mut self, [low, high]: [[i64; 3]; 2], value: impl Fn([i64; 3]) -> f32) {
        let [least, greatest] = self.window;
        let [x, y, z] =
            [0, 1, 2].map(|axis| low[axis].max(least[axis])..=high[axis].min(greatest[axis]));
        for k in z {
            for j in y.clone() {
                let [row, slice] = [j - self.first[1], k - self.first[2]].map(|at| at as usize);
                let row = (slice * self.counts[1] + row) * self.counts[0];
                for i in x.clone() {
                    self.values[row + (i - self.first[0]) as usize] = value([i, j, k]);
                }
            }
        }
    }
}

/// Of named grids those that are read: that of the densities, and that which emits.
pub(super) fn chosen<G>(
    format: &str,
    grids: Vec<(String, G)>,
    notes: &mut Notes,
) -> Result<[Option<G>; 2], LoadError> {
    let called = |wanted: &str| grids.iter().position(|(name, _)| name == wanted);
    let emits = |name: &String| EMISSION.contains(&name.as_str());
    let density = called(DENSITY).or_else(|| grids.iter().position(|(name, _)| !emits(name)));
    let emission = EMISSION.iter().find_map(|name| called(name));
    if density.is_none() && emission.is_none() {
        let what = format!("a {format} file without a grid of densities of the type float");
        return Err(LoadError::Unsupported(what));
    }
    let mut found = [None, None];
    for (index, (name, grid)) in grids.into_iter().enumerate() {
        if Some(index) == density {
            if name != DENSITY {
                let name = printable(&name);
                notes.add(format!("the grid \"{name}\" is the density"));
            }
            found[0] = Some(grid);
        } else if Some(index) == emission {
            let name = printable(&name);
            // Whether it is used is said once its voxels are known.
            notes.add(format!("the grid \"{name}\" is named as an emission"));
            found[1] = Some(grid);
        } else {
            left_out(&name, notes);
        }
    }
    Ok(found)
}

/// Says that a grid is not read.
pub(super) fn left_out(name: &str, notes: &mut Notes) {
    let name = printable(name);
    notes.add(format!("the grid \"{name}\" is left out"));
}

/// A scene of a grid of densities and one that emits, one of them at least.
pub(super) fn scene_of<G: VoxelGrid>(
    [density, mut emission]: [Option<G>; 2],
    options: &LoadOptions,
    budget: &mut Budget,
    mut notes: Notes,
) -> Result<Loaded, LoadError> {
    if emission
        .as_ref()
        .is_some_and(|grid| grid.indices().is_none())
    {
        notes.add("the emission is left out: no voxels");
        emission = None;
    }
    let density = density.filter(|grid| grid.indices().is_some() || emission.is_none());
    if let (Some(density), Some(other)) = (&density, &emission)
        && !density.placement().is_that_of(&other.placement())
    {
        notes.add("the emission is left out, whose transform is not that of the densities");
        emission = None;
    }
    if emission.is_some() {
        notes.add("the emission is radiance per unit of length");
    }
    let both = || density.iter().chain(&emission);
    let boxes: Vec<_> = both().filter_map(VoxelGrid::indices).collect();
    let (first, resolution) = samples::<G>(&boxes)?;
    let samples = resolution.iter().map(|&n| u64::from(n)).product();
    let values = |what, grid: &Option<G>, budget: &mut Budget| {
        let Some(grid) = grid else {
            return Ok(None);
        };
        budget.take(what, samples, size_of::<f32>())?;
        Dense::of(grid, first, resolution).map(Some)
    };
    let densities = values("the densities", &density, budget)?;
    let emitted = values("the emission", &emission, budget)?;
    for grid in both() {
        if grid.background() != 0.0 {
            notes.add(format!(
                "the background of {} outside of the voxels is left out",
                grid.background()
            ));
        }
    }
    let Some(placement) = both().next().map(VoxelGrid::placement) else {
        return Ok(Loaded::default());
    };
    // A voxel is a unit of the grid's own space, which begins at its first sample.
    let high = resolution.map(|count| (count - 1) as f32);
    let bounds = Bounds::new([0.0; 3], high)?;
    // Optical depths, and what a ray gathers, stay what they are in the file.
    let scale = (1.0 / options.unit) as f32;
    let densities = match densities {
        Some(densities) => densities,
        None => {
            budget.take("the densities", samples, size_of::<f32>())?;
            vec![0.0; samples as usize]
        }
    };
    let linear = Interpolation::Linear;
    let mut grid = DensityGrid::new(bounds, resolution, densities, scale, linear)?;
    if let Some(emitted) = emitted {
        budget.take("the emission", samples, size_of::<Vec3>())?;
        let colours = emitted.into_iter().map(|value| Vec3::splat(scale * value));
        grid = grid.with_emission(colours.collect())?;
    }
    let scene = Scene {
        translucent: vec![
            grid.with_transform(placement.of_samples(first, options))?
                .into(),
        ],
        ..Scene::default()
    };
    Ok(Loaded {
        scene,
        notes: notes.into_vec(),
        ..Loaded::default()
    })
}

impl Placement {
    /// From samples, counted from the first, to the scene.
    fn of_samples(&self, first: [i64; 3], options: &LoadOptions) -> Affine3A {
        let options = options.unit * options.up.rotation();
        let first = DVec3::from_array(first.map(|index| index as f64));
        let (turn, shift) = (
            options * self.turn,
            options * (self.turn * first + self.shift),
        );
        Affine3A::from_cols(
            turn.x_axis.as_vec3().into(),
            turn.y_axis.as_vec3().into(),
            turn.z_axis.as_vec3().into(),
            shift.as_vec3().into(),
        )
    }
}

/// The first index along each axis, and the numbers of samples: those of the voxels in
/// these boxes and one more on each side, where the density has fallen to none.
fn samples<G: VoxelGrid>(boxes: &[[[i64; 3]; 2]]) -> Result<([i64; 3], [u32; 3]), LoadError> {
    let format = G::FORMAT;
    if boxes.is_empty() {
        let what = format!("the voxels of a {format} grid");
        return Err(LoadError::bad_value(what, "none", "at least one voxel"));
    }
    let mut first = [0; 3];
    let mut resolution = [0; 3];
    let mut samples = 1_u64;
    for axis in 0..3 {
        let low = boxes.iter().map(|[low, _]| low[axis]).min();
        let high = boxes.iter().map(|[_, high]| high[axis]).max();
        let (low, high) = (low.unwrap_or(0), high.unwrap_or(0));
        let count = high - low + 3;
        samples = samples.saturating_mul(count as u64);
        first[axis] = low - 1;
        // A larger one is refused below.
        resolution[axis] = count.min(u32::MAX.into()) as u32;
    }
    if samples > MAX_SAMPLES {
        let [x, y, z] = resolution;
        return Err(LoadError::TooLarge {
            what: format!("a {format} grid of {x} x {y} x {z}"),
            bytes: samples.saturating_mul(4),
            limit: 4 * MAX_SAMPLES,
        });
    }
    Ok((first, resolution))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::MAX_DECODED_BYTES;

    /// A voxel of 1, or none.
    struct Voxel {
        is_there: bool,
        shift: DVec3,
    }

    impl VoxelGrid for Voxel {
        const FORMAT: &'static str = "voxel";

        fn indices(&self) -> Option<[[i64; 3]; 2]> {
            self.is_there.then_some([[0; 3]; 2])
        }

        fn placement(&self) -> Placement {
            Placement {
                turn: DMat3::IDENTITY,
                shift: self.shift,
            }
        }

        fn background(&self) -> f32 {
            0.0
        }

        fn fill(&self, dense: &mut Dense) -> Result<(), LoadError> {
            dense.fill([[0; 3]; 2], 1.0);
            Ok(())
        }
    }

    #[test]
    fn notes_tell_which_grids_are_used() {
        let notes = |density: &str, [is_there, is_elsewhere]: [bool; 2]| {
            let shift = if is_elsewhere { DVec3::X } else { DVec3::ZERO };
            let [here, there] = [(true, DVec3::ZERO), (is_there, shift)]
                .map(|(is_there, shift)| Voxel { is_there, shift });
            let grids = vec![(density.to_owned(), here), ("flames".to_owned(), there)];
            let mut notes = Notes::default();
            let grids = chosen("voxel", grids, &mut notes).unwrap();
            let mut budget = Budget::new(MAX_DECODED_BYTES);
            let loaded = scene_of(grids, &LoadOptions::default(), &mut budget, notes);
            loaded.unwrap().notes
        };
        let named = "the grid \"flames\" is named as an emission";
        let used = "the emission is radiance per unit of length";
        assert_eq!(notes("density", [true, false]), [named, used]);
        let none = "the emission is left out: no voxels";
        assert_eq!(notes("density", [false, false]), [named, none]);
        let moved = "the emission is left out, whose transform is not that of the densities";
        assert_eq!(notes("density", [true, true]), [named, moved]);
        let density = "the grid \"soot\" is the density";
        assert_eq!(notes("soot", [true, false]), [density, named, used]);
    }
}
