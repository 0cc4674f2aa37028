//! Smoke on a grid.

use glam::{Affine3A, DMat3, DVec3, Vec3};

use super::cell_walk::{CellSpan, CellWalk, OccupiedCells};
use super::occupancy::Occupancy;
use super::{check_colour, check_extinction};
use crate::cubic::Cubic;
use crate::{Bounds, PhaseFunction, SceneError};

/// The largest number of samples of a grid: 2²⁸, which is 1 GiB.
pub const MAX_SAMPLES: u64 = 1 << 28;

/// How a [`DensityGrid`] is interpolated between its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Interpolation {
    /// Each sample fills a voxel: the box is divided into one voxel for each sample.
    Constant,
    /// Trilinear between samples; the outer samples are on the faces of the box. Along an axis
    /// with a single sample the density is constant.
    Linear,
}

impl Interpolation {
    /// The number of cells along each axis of so many samples.
    fn cells(self, samples: [u32; 3]) -> [u32; 3] {
        match self {
            Self::Constant => samples,
            Self::Linear => samples.map(|count| (count - 1).max(1)),
        }
    }
}

/// A medium whose density varies within a box, with nothing outside.
///
/// At a density `d` the extinction coefficient of a colour channel is `scale × tint × d`, 1/m,
/// and the scattering coefficient is the albedo times that. A new grid has a tint and an albedo
/// of 1 in every channel, scatters isotropically, emits nothing, and is placed where its box
/// is.
#[derive(Debug, Clone, PartialEq)]
pub struct DensityGrid {
    local_bounds: Bounds,
    transform: Affine3A,
    bounds: Bounds,
    /// World position of the corner at which cell coordinates are 0.
    corner: DVec3,
    /// From offsets from that corner, in world space, to cells.
    cells_per_metre: DMat3,
    resolution: [u32; 3],
    density: Vec<f32>,
    max_density: f32,
    max_density_at_faces: f32,
    scale: f32,
    interpolation: Interpolation,
    tint: Vec3,
    albedo: Vec3,
    /// One per sample, or empty.
    albedo_samples: Vec<Vec3>,
    /// One per sample, or empty.
    emission: Vec<Vec3>,
    phase: PhaseFunction,
    /// Follows from the densities and the emission.
    occupancy: Occupancy,
    /// Around the occupied cells.
    occupied_bounds: Bounds,
}

impl DensityGrid {
    /// `resolution` samples of a density along x, y and z of `bounds`, x
    /// fastest. The extinction coefficient is `scale` × density, 1/m.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] for a resolution of 0, more than
    /// [`MAX_SAMPLES`], a density or scale outside of 0 to 1e15;
    /// [`SceneError::LengthMismatch`] unless there is one density per sample.
    pub fn new(
        bounds: Bounds,
        resolution: [u32; 3],
        density: Vec<f32>,
        scale: f32,
        interpolation: Interpolation,
    ) -> Result<Self, SceneError> {
        let [x, y, z] = resolution.map(u64::from);
        let count = x.saturating_mul(y).saturating_mul(z);
        if count == 0 || count > MAX_SAMPLES {
            return Err(SceneError::bad_value(
                "density grid",
                "resolution",
                format!("{x} x {y} x {z}"),
                "1 to 2^28 samples",
            ));
        }
        check_length("the list of densities", density.len(), count as usize)?;
        check_extinction(|| OWNER.into(), "scale", scale)?;
        for (index, &value) in density.iter().enumerate() {
            check_extinction(|| format!("{OWNER}, sample {index}"), "density", value)?;
        }
        let cells = interpolation.cells(resolution);
        let occupancy = Occupancy::new([cells, resolution], interpolation, |index| {
            density[index] > 0.0
        });
        let [max_density, max_density_at_faces] = largest(&density, resolution);
        let mut grid = Self {
            local_bounds: bounds,
            transform: Affine3A::IDENTITY,
            bounds,
            corner: DVec3::ZERO,
            cells_per_metre: DMat3::IDENTITY,
            resolution,
            density,
            max_density,
            max_density_at_faces,
            scale,
            interpolation,
            tint: Vec3::ONE,
            albedo: Vec3::ONE,
            albedo_samples: Vec::new(),
            emission: Vec::new(),
            phase: PhaseFunction::Isotropic,
            occupancy,
            occupied_bounds: bounds,
        };
        grid.place(DMat3::IDENTITY, DVec3::ZERO);
        Ok(grid)
    }

    /// Updates everything that follows from the place of the box.
    fn place(&mut self, turn: DMat3, shift: DVec3) {
        let (min, max) = (self.local_bounds.min(), self.local_bounds.max());
        let cells = DVec3::from_array(self.cells().map(f64::from));
        let per_metre = cells / (max.as_dvec3() - min.as_dvec3());
        self.corner = turn * min.as_dvec3() + shift;
        self.cells_per_metre = DMat3::from_diagonal(per_metre) * turn.inverse();
        self.occupied_bounds = self.find_occupied_bounds();
    }

    fn find_occupied_bounds(&self) -> Bounds {
        let [first, end] = match self.occupancy.range() {
            Some(range) if range != [[0; 3], self.cells()] => range,
            _ => return self.bounds,
        };
        let to_metres = self.cells_per_metre.inverse();
        let corners: [DVec3; 8] = std::array::from_fn(|corner| {
            let cell = [0, 1, 2].map(|axis| [first, end][corner >> axis & 1][axis]);
            self.corner + to_metres * DVec3::from_array(cell.map(f64::from))
        });
        let inside = around(corners).and_then(|occupied| {
            // Rounding must not make it larger than the whole.
            let [min, max] = [self.bounds.min(), self.bounds.max()];
            Bounds::new(occupied.min().max(min), occupied.max().min(max))
        });
        inside.unwrap_or(self.bounds)
    }

    /// The same grid with its box rotated, scaled, sheared and moved by
    /// `transform`, from the space of its box to the world's; replaces an
    /// earlier transform. Extinction stays per metre of the world.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] for a transform that is not finite, flattens the
    /// box or moves a corner of it beyond 1e9 m.
    pub fn with_transform(mut self, transform: Affine3A) -> Result<Self, SceneError> {
        let columns = [
            transform.matrix3.x_axis,
            transform.matrix3.y_axis,
            transform.matrix3.z_axis,
        ]
        .map(|axis| Vec3::from(axis).as_dvec3());
        let turn = DMat3::from_cols(columns[0], columns[1], columns[2]);
        let shift = Vec3::from(transform.translation).as_dvec3();
        let size: f64 = columns.iter().map(|axis| axis.length()).product();
        // Below this, f32 cannot tell the volume from 0.
        if !(transform.is_finite() && turn.determinant().abs() > 1e-6 * size) {
            return Err(SceneError::bad_value(
                OWNER,
                "transform",
                transform,
                "finite numbers that do not flatten the box",
            ));
        }
        self.bounds = if transform == Affine3A::IDENTITY {
            self.local_bounds
        } else {
            let corners = self.local_bounds.corners();
            around(corners.map(|corner| turn * corner.as_dvec3() + shift))?
        };
        self.transform = transform;
        self.place(turn, shift);
        Ok(self)
    }

    /// The same grid with an extinction of its own in each colour channel: a
    /// factor on the scale, linear RGB.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] unless all three are from 0 to 1e6.
    pub fn with_tint(self, tint: Vec3) -> Result<Self, SceneError> {
        check_colour(|| OWNER.into(), "tint", tint, 1e6, "numbers from 0 to 1e6")?;
        Ok(Self { tint, ..self })
    }

    /// The same grid with an albedo: the share of the extinction that is scattering, linear
    /// RGB. If samples have albedos of their own, it multiplies these.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] unless all three are from 0 to 1.
    pub fn with_albedo(self, albedo: Vec3) -> Result<Self, SceneError> {
        check_colour(|| OWNER.into(), "albedo", albedo, 1.0, "shares from 0 to 1")?;
        Ok(Self { albedo, ..self })
    }

    /// The same grid with an albedo for each sample, interpolated like the
    /// density; none if the list is empty.
    ///
    /// # Errors
    /// [`SceneError::LengthMismatch`] unless there is one per sample,
    /// [`SceneError::BadValue`] unless all are from 0 to 1.
    pub fn with_albedo_samples(self, albedo: Vec<Vec3>) -> Result<Self, SceneError> {
        self.check_samples("the list of albedos", albedo.len())?;
        for (index, &value) in albedo.iter().enumerate() {
            let owner = || format!("{OWNER}, sample {index}");
            check_colour(owner, "albedo", value, 1.0, "shares from 0 to 1")?;
        }
        Ok(Self {
            albedo_samples: albedo,
            ..self
        })
    }

    /// The same grid with an emission for each sample: the radiance from one metre of it,
    /// linear RGB, interpolated like the density; none if the list is empty.
    ///
    /// # Errors
    /// [`SceneError::LengthMismatch`] unless there is one per sample,
    /// [`SceneError::BadValue`] unless all are from 0 to 1e15.
    pub fn with_emission(self, emission: Vec<Vec3>) -> Result<Self, SceneError> {
        self.check_samples("the list of emissions", emission.len())?;
        for (index, &value) in emission.iter().enumerate() {
            let owner = || format!("{OWNER}, sample {index}");
            check_colour(owner, "emission", value, 1e15, "numbers from 0 to 1e15")?;
        }
        let counts = |index: usize| {
            let emits = emission
                .get(index)
                .is_some_and(|light| *light != Vec3::ZERO);
            emits || self.density[index] > 0.0
        };
        let samples = [self.cells(), self.resolution];
        let occupancy = Occupancy::new(samples, self.interpolation, counts);
        let mut grid = Self {
            emission,
            occupancy,
            ..self
        };
        grid.occupied_bounds = grid.find_occupied_bounds();
        Ok(grid)
    }

    /// The same grid with another phase function.
    ///
    /// # Errors
    /// [`SceneError::PhaseFunction`] if its parameters are out of range.
    pub fn with_phase(self, phase: PhaseFunction) -> Result<Self, SceneError> {
        let phase = phase.checked()?;
        Ok(Self { phase, ..self })
    }

    fn check_samples(&self, what: &'static str, actual: usize) -> Result<(), SceneError> {
        if actual == 0 {
            return Ok(());
        }
        check_length(what, actual, self.density.len())
    }

    /// An axis-aligned box of the world around all of it: the box itself unless
    /// a transform rotates it.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// An axis-aligned box of the world around all cells that are
    /// [occupied](DensityGrid::is_occupied); that of the whole grid if none is. It is often much
    /// smaller than the grid.
    pub fn occupied_bounds(&self) -> Bounds {
        self.occupied_bounds
    }

    /// True if there is anything in a cell: if one of the samples at its corners has a density
    /// above 0 or emits light.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn is_occupied(&self, cell: [u32; 3]) -> bool {
        self.occupancy.is_occupied(cell)
    }

    /// [`is_occupied`](DensityGrid::is_occupied) of all cells, x fastest, as the bits of words,
    /// the lowest bit first.
    pub fn occupied(&self) -> &[u32] {
        self.occupancy.words()
    }

    /// The box in its own space, before the [transform](DensityGrid::transform).
    pub fn local_bounds(&self) -> Bounds {
        self.local_bounds
    }

    /// From the space of the box to the world.
    pub fn transform(&self) -> Affine3A {
        self.transform
    }

    /// Number of samples along x, y and z.
    pub fn resolution(&self) -> [u32; 3] {
        self.resolution
    }

    /// The densities, x fastest.
    pub fn density(&self) -> &[f32] {
        &self.density
    }

    /// Extinction coefficient of a density of 1, 1/m.
    pub fn scale(&self) -> f32 {
        self.scale
    }

    /// The factor on the extinction of each colour channel.
    pub fn tint(&self) -> Vec3 {
        self.tint
    }

    /// The albedo of the grid; see also [`albedo_samples`](DensityGrid::albedo_samples).
    pub fn albedo(&self) -> Vec3 {
        self.albedo
    }

    /// The albedo of each sample, in the order of the densities; empty if they
    /// have none of their own.
    pub fn albedo_samples(&self) -> &[Vec3] {
        &self.albedo_samples
    }

    /// The emission of each sample, in the order of the densities; empty if there
    /// is none.
    pub fn emission(&self) -> &[Vec3] {
        &self.emission
    }

    /// How scattered light spreads over directions.
    pub fn phase(&self) -> PhaseFunction {
        self.phase
    }

    /// The interpolation between samples.
    pub fn interpolation(&self) -> Interpolation {
        self.interpolation
    }

    /// The same grid with another scale.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] unless it is from 0 to 1e15.
    pub fn with_scale(self, scale: f32) -> Result<Self, SceneError> {
        check_extinction(|| OWNER.into(), "scale", scale)?;
        Ok(Self { scale, ..self })
    }

    /// The largest density.
    pub fn max_density(&self) -> f32 {
        self.max_density
    }

    /// The largest density at the faces of the box. Unless it is 0 the medium ends there at an
    /// edge; with [`Interpolation::Constant`] there are edges between samples too.
    pub fn max_density_at_faces(&self) -> f32 {
        self.max_density_at_faces
    }

    /// Number of cells along each axis; within a cell the extinction is a polynomial.
    pub fn cells(&self) -> [u32; 3] {
        self.interpolation.cells(self.resolution)
    }

    /// The coordinates of a point of the world in cells, from the corner of the grid: inside
    /// the box they are from 0 to [`cells`](DensityGrid::cells).
    pub fn in_cells(&self, point: DVec3) -> DVec3 {
        self.cells_per_metre * (point - self.corner)
    }

    /// World position of the corner from which cells are counted, and the matrix
    /// that takes world offsets from it to cells.
    pub fn cell_space(&self) -> (DVec3, DMat3) {
        (self.corner, self.cells_per_metre)
    }

    /// The cells on the line `origin + t direction` for t from `from` to `to`, from front to
    /// back. Only cells in which the line has some length are included. Both ends may be
    /// infinite.
    ///
    /// A line in a face between two cells counts as being in one of them.
    pub fn cells_along(&self, origin: DVec3, direction: DVec3, from: f64, to: f64) -> CellWalk {
        let start = self.in_cells(origin);
        CellWalk::new(
            start,
            self.cells_per_metre * direction,
            self.cells(),
            from,
            to,
        )
    }

    /// Those of [`cells_along`](DensityGrid::cells_along) that are
    /// [occupied](DensityGrid::is_occupied): what is on the line, without what is empty.
    pub fn occupied_cells_along(
        &self,
        origin: DVec3,
        direction: DVec3,
        from: f64,
        to: f64,
    ) -> OccupiedCells<'_> {
        let (start, slope) = (self.in_cells(origin), self.cells_per_metre * direction);
        let [from, to] = self.occupancy.clip(start, slope, [from, to]);
        OccupiedCells {
            grid: self,
            walk: CellWalk::new(start, slope, self.cells(), from, to),
        }
    }

    /// The weighted mean of `sample` over the samples around a point of a cell; each coordinate
    /// of `place` is from 0 to 1 across the cell.
    fn interpolate<T>(&self, cell: [u32; 3], place: DVec3, sample: impl Fn(usize) -> T) -> T
    where
        T: std::ops::Add<Output = T> + std::ops::Sub<Output = T> + std::ops::Mul<f64, Output = T>,
        T: Copy,
    {
        let at = self.corners(cell);
        match self.interpolation {
            Interpolation::Constant => sample(at[0]),
            Interpolation::Linear => {
                let mix = |a: T, b: T, t: f64| a + (b - a) * t;
                let row = |i: usize| mix(sample(at[i]), sample(at[i + 1]), place.x);
                let slice = |i: usize| mix(row(i), row(i + 2), place.y);
                mix(slice(0), slice(4), place.z)
            }
        }
    }

    /// Indices of the samples at the corners of a cell: corner i has the larger coordinate on
    /// the axes whose bits are set in i. With a single sample along an axis, or with voxels,
    /// both corners of an edge have the same sample.
    fn corners(&self, cell: [u32; 3]) -> [usize; 8] {
        let [nx, ny, _] = self.resolution.map(|count| count as usize);
        let [x, y, z] = cell.map(|index| index as usize);
        let next = |axis: usize| match self.interpolation {
            Interpolation::Constant => 0,
            Interpolation::Linear => usize::from(cell[axis] + 1 < self.resolution[axis]),
        };
        let steps = [next(0), next(1) * nx, next(2) * nx * ny];
        let first = (z * ny + y) * nx + x;
        std::array::from_fn(|i| {
            first + (i & 1) * steps[0] + (i >> 1 & 1) * steps[1] + (i >> 2) * steps[2]
        })
    }

    /// The extinction coefficient at `place` of a cell where the tint is 1, 1/m:
    /// each coordinate of `place` from 0 to 1 across the cell.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn extinction(&self, cell: [u32; 3], place: DVec3) -> f64 {
        let density = self.interpolate(cell, place, |index| f64::from(self.density[index]));
        f64::from(self.scale) * density
    }

    /// The albedo at `place` of a cell.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn albedo_in(&self, cell: [u32; 3], place: DVec3) -> DVec3 {
        let albedo = self.albedo.as_dvec3();
        if self.albedo_samples.is_empty() {
            return albedo;
        }
        let sample = |index: usize| self.albedo_samples[index].as_dvec3();
        albedo * self.interpolate(cell, place, sample)
    }

    /// The emission at `place` of a cell, radiance per metre.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn emission_in(&self, cell: [u32; 3], place: DVec3) -> DVec3 {
        if self.emission.is_empty() {
            return DVec3::ZERO;
        }
        self.interpolate(cell, place, |index| self.emission[index].as_dvec3())
    }

    /// The extinction along the span of a cell where the tint is 1, 1/m.
    ///
    /// Along a line the product of three linear functions is a cubic; its
    /// coefficients are means of the density at corners of the box between the
    /// two ends, which lies in the cell: none is negative.
    pub(crate) fn cubic(&self, span: &CellSpan) -> Cubic {
        let scale = f64::from(self.scale);
        let at = self.corners(span.cell);
        if self.interpolation == Interpolation::Constant {
            return Cubic::constant(scale * f64::from(self.density[at[0]]));
        }
        let corner = at.map(|index| f64::from(self.density[index]));
        if corner == [0.0; 8] {
            return Cubic::constant(0.0);
        }
        let ends = [span.entry, span.exit];
        // Interpolated along x at either end, then along y, then along z.
        let rows = ends.map(|end| [0, 2, 4, 6].map(|i| mix(corner[i], corner[i + 1], end.x)));
        let slices = rows.map(|row| ends.map(|end| [0, 2].map(|i| mix(row[i], row[i + 1], end.y))));
        let values = slices.map(|row| row.map(|[near, far]| ends.map(|end| mix(near, far, end.z))));
        let value = |i: usize| values[i & 1][i >> 1 & 1][i >> 2];
        let third = 1.0 / 3.0;
        Cubic([
            scale * value(0),
            scale * third * (value(1) + value(2) + value(4)),
            scale * third * (value(3) + value(5) + value(6)),
            scale * value(7),
        ])
    }

    /// The optical depth of the span of a cell where the tint is 1, for a line
    /// whose direction is a unit vector: exact but for rounding.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn optical_depth(&self, span: &CellSpan) -> f64 {
        // ½ ± ½/√3: Gauss's rule, which is exact for a cubic.
        const NODES: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];
        let at = self.corners(span.cell);
        let length = f64::from(self.scale) * (span.to - span.from);
        if self.interpolation == Interpolation::Constant {
            return length * f64::from(self.density[at[0]]);
        }
        let corner = at.map(|index| f64::from(self.density[index]));
        if corner == [0.0; 8] {
            return 0.0;
        }
        let density =
            NODES.map(|share| trilinear(&corner, span.entry * (1.0 - share) + span.exit * share));
        length * (0.5 * (density[0] + density[1]))
    }

    /// The cell that contains a point of the world, and the position in this cell; `None`
    /// outside of the box.
    pub fn cell_at(&self, point: DVec3) -> Option<([u32; 3], DVec3)> {
        // A bound on the rounding of a point on a face.
        const ROUNDING: f64 = 1e-12;
        let place = self.in_cells(point);
        let cells = self.cells();
        let size = DVec3::from_array(cells.map(f64::from));
        let slack = ROUNDING * size;
        if !(place.cmpge(-slack).all() && place.cmple(size + slack).all()) {
            return None;
        }
        let cell = [0, 1, 2].map(|axis| (place[axis] as u32).min(cells[axis] - 1));
        let place = place - DVec3::from_array(cell.map(f64::from));
        Some((cell, place.clamp(DVec3::ZERO, DVec3::ONE)))
    }

    /// The extinction coefficient at a point where the tint is 1, 1/m; 0 outside
    /// of the box.
    pub fn extinction_at(&self, point: Vec3) -> f32 {
        let found = self.cell_at(point.as_dvec3());
        found.map_or(0.0, |(cell, place)| self.extinction(cell, place) as f32)
    }
}

/// The largest of all densities, and of those on the faces of the box.
fn largest(density: &[f32], [x, y, z]: [u32; 3]) -> [f32; 2] {
    let most = |densities: &[f32]| densities.iter().copied().fold(0.0, f32::max);
    let (mut all, mut faces) = (0.0_f32, 0.0_f32);
    for (row, densities) in (0..).zip(density.chunks_exact(x as usize)) {
        let (of_row, ends) = (most(densities), densities[0].max(densities[x as usize - 1]));
        let is_at_end = |place: u32, count: u32| place == 0 || place == count - 1;
        let on_face = is_at_end(row % y, y) || is_at_end(row / y, z);
        all = all.max(of_row);
        faces = faces.max(if on_face { of_row } else { ends });
    }
    [all, faces]
}

/// A box of single precision around points.
fn around(corners: [DVec3; 8]) -> Result<Bounds, SceneError> {
    let corners = corners.map(|corner| corner.as_vec3());
    let least = corners.into_iter().fold(Vec3::INFINITY, Vec3::min);
    let greatest = corners.into_iter().fold(Vec3::NEG_INFINITY, Vec3::max);
    // Corners are rounded to single precision in either direction.
    let margin = f32::EPSILON * least.abs().max(greatest.abs());
    Bounds::new(least - margin, greatest + margin)
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

/// Between the corners of a cell, in the order of [`DensityGrid::corners`].
fn trilinear(corner: &[f64; 8], place: DVec3) -> f64 {
    let row = |i: usize| mix(corner[i], corner[i + 1], place.x);
    let slice = |i: usize| mix(row(i), row(i + 2), place.y);
    mix(slice(0), slice(4), place.z)
}

const OWNER: &str = "density grid";

fn check_length(what: &'static str, actual: usize, expected: usize) -> Result<(), SceneError> {
    if actual == expected {
        return Ok(());
    }
    Err(SceneError::LengthMismatch {
        owner: OWNER.into(),
        what,
        actual,
        expected,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit() -> Bounds {
        Bounds::new(Vec3::ZERO, Vec3::ONE).unwrap()
    }

    #[test]
    fn samples_are_where_the_interpolation_puts_them() {
        let density = (0..12).map(|i| i as f32).collect::<Vec<_>>();
        let grid = |interpolation| {
            DensityGrid::new(unit(), [3, 2, 2], density.clone(), 2.0, interpolation).unwrap()
        };
        let voxels = grid(Interpolation::Constant);
        assert_eq!(voxels.extinction_at(Vec3::new(0.4, 0.1, 0.9)), 2.0 * 7.0);
        assert_eq!(voxels.extinction_at(Vec3::ONE), 2.0 * 11.0);
        assert_eq!(voxels.extinction_at(Vec3::new(0.5, 1.01, 0.5)), 0.0);
        let smooth = grid(Interpolation::Linear);
        assert_eq!(smooth.extinction_at(Vec3::ONE), 2.0 * 11.0);
        // Linear numbers are met exactly anywhere.
        let at = Vec3::new(0.25, 0.5, 0.125);
        let expected = 0.25 * 2.0 + 0.5 * 3.0 + 0.125 * 6.0;
        assert!((smooth.extinction_at(at) - 2.0 * expected).abs() < 1e-5);
        assert_eq!(smooth.extinction_at(Vec3::new(0.5, f32::NAN, 0.5)), 0.0);
    }

    #[test]
    fn cells_are_occupied_where_a_sample_at_a_corner_counts() {
        let mut density = vec![0.0; 4 * 3 * 3];
        // The sample (2, 1, 0).
        density[6] = 1.0;
        for interpolation in [Interpolation::Constant, Interpolation::Linear] {
            let new = |density: &[f32]| {
                DensityGrid::new(unit(), [4, 3, 3], density.to_vec(), 1.0, interpolation).unwrap()
            };
            let grid = new(&density);
            let [nx, ny, nz] = grid.cells();
            let all: Vec<_> = (0..nz)
                .flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
                .collect();
            let occupied = |grid: &DensityGrid| -> Vec<[u32; 3]> {
                let cells = all.iter().copied();
                cells.filter(|&cell| grid.is_occupied(cell)).collect()
            };
            let of_corners = |grid: &DensityGrid| -> Vec<[u32; 3]> {
                let counts = |&index: &usize| {
                    grid.density[index] > 0.0
                        || grid
                            .emission
                            .get(index)
                            .is_some_and(|&light| light != Vec3::ZERO)
                };
                let cells = all.iter().copied();
                cells
                    .filter(|&cell| grid.corners(cell).iter().any(counts))
                    .collect()
            };
            assert_eq!(occupied(&grid), of_corners(&grid));
            for (index, cell) in all.iter().enumerate() {
                let bit = grid.occupied()[index / 32] >> (index % 32) & 1;
                assert_eq!(grid.is_occupied(*cell), bit == 1);
            }
            let inside = grid.occupied_bounds();
            let whole = grid.bounds();
            assert!(inside.min().x > 0.3 && inside.max().x <= 1.0, "{inside:?}");
            assert!(inside.max().z < 0.6 && inside.min().y >= whole.min().y);
            // A transform takes its corners along.
            let turned = Affine3A::from_rotation_z(0.5 * std::f32::consts::PI);
            let turned = grid
                .clone()
                .with_transform(turned)
                .unwrap()
                .occupied_bounds();
            assert!((turned.min().y - inside.min().x).abs() < 1e-6, "{turned:?}");
            assert!((turned.max().x + inside.min().y).abs() < 1e-6, "{turned:?}");
            // What emits light is there even without a density.
            let mut emission = vec![Vec3::ZERO; density.len()];
            emission[35] = Vec3::X;
            let glowing = grid.with_emission(emission).unwrap();
            assert_eq!(occupied(&glowing), of_corners(&glowing));
            assert!(glowing.is_occupied([nx - 1, ny - 1, nz - 1]));
            let nothing = new(&vec![0.0; density.len()]);
            assert_eq!(occupied(&nothing), Vec::<[u32; 3]>::new());
            assert_eq!(nothing.occupied_bounds(), nothing.bounds());
        }
    }

    #[test]
    fn occupied_cells_on_a_line_are_the_cells_without_the_empty_ones() {
        let density = (0..6 * 5 * 4)
            .map(|i| f32::from(u8::from(i % 3 == 0)))
            .collect();
        let grid = DensityGrid::new(unit(), [6, 5, 4], density, 1.0, Interpolation::Constant);
        let grid = grid.unwrap();
        for direction in [DVec3::ONE, DVec3::X, DVec3::new(-0.3, 0.8, 0.1)] {
            let origin = DVec3::splat(0.5) - direction;
            let all = grid.cells_along(origin, direction, 0.0, f64::INFINITY);
            let expected: Vec<_> = all.filter(|span| grid.is_occupied(span.cell)).collect();
            let found = grid.occupied_cells_along(origin, direction, 0.0, f64::INFINITY);
            assert!(!expected.is_empty());
            assert_eq!(found.collect::<Vec<_>>(), expected);
        }
    }

    #[test]
    fn bad_grids_name_their_cause() {
        let new = |resolution, density, scale| {
            DensityGrid::new(unit(), resolution, density, scale, Interpolation::Linear)
        };
        for (grid, cause) in [
            (new([2, 0, 2], vec![], 1.0), "2 x 0 x 2"),
            (new([u32::MAX; 3], vec![], 1.0), "2^28"),
            (new([1, 1, 2], vec![0.5], 1.0), "1 entries"),
            (new([1, 1, 2], vec![0.5, -1.0], 1.0), "sample 1"),
            (new([1, 1, 1], vec![f32::NAN], 1.0), "NaN"),
            (new([1, 1, 1], vec![1.0], f32::INFINITY), "scale is inf"),
        ] {
            let error = grid.unwrap_err().to_string();
            assert!(error.contains(cause), "{error}");
        }
    }
}
