//! The nearest of many triangles in each texel of a face.
//!
//! First all triangles are sorted into bands of rows by the boxes around them, without those that
//! cover no texel centre. Then each band makes the linear functions of its triangles, a block of
//! them at a time, and covers its texels. Both steps are loops over arrays that the compiler turns
//! into vector instructions, or vectors by hand where texels are covered, for AVX-512, for AVX2
//! and for what every processor has, chosen when the program runs. All operations round as those
//! of a [`Footprint`](super::Footprint) do, so that depths have the same bits. Triangles are
//! transformed twice rather than kept: a footprint has five times as many bytes as a triangle, and
//! those that cover nothing are many.
//!
//! What binds is arithmetic, of triangles where they are small and of texels where they are large:
//! over 330,000 triangles, most of them smaller than a texel, and over 132 large ones it takes a
//! quarter of the time of one footprint after the other.
//!
//! Depths of a band are collected in f64 and rounded at its end: rounding keeps their order, so
//! the nearest of them is the same.

use std::sync::LazyLock;

use glam::{DVec3, Vec3};
use gpu_backend::Cpu;
use pulp::{Arch, Simd, WithSimd};

use super::{Central, Face, Linear, Lines, Parallel, Projection, Rays};

/// Rows that are rendered as one unit of work.
const BAND: u32 = 16;

/// Triangles that are sorted into bands as one unit of work.
const CHUNK: usize = 4096;

/// Triangles of a block: a few vectors of any processor, and little enough for the first-level
/// cache.
const TOGETHER: usize = 32;

/// Lanes of the longest vector.
const MOST_LANES: usize = 8;

/// Triangles of up to so many columns are covered without asking in each row where they begin
/// and end.
const NARROW: u32 = 8;

/// The best instructions that this processor has: asked once.
fn arch() -> Arch {
    static ARCH: LazyLock<Arch> = LazyLock::new(Arch::new);
    *ARCH
}

/// Writes the depth of the nearest triangle in each texel of a face, row by row from the top, and
/// `empty` where there is none or all are at least so far away. Depths are those of
/// [`Footprint::for_each`](super::Footprint::for_each).
///
/// Bands of rows are independent of each other, and a minimum does not depend on the order, so
/// the result does not depend on threads.
///
/// # Panics
/// Unless `texels` has `resolution` × `resolution` texels, or if there are 2³² triangles.
pub fn nearest_depths(
    cpu: &Cpu,
    face: &Face,
    triangles: &[[Vec3; 3]],
    resolution: u32,
    empty: f32,
    texels: &mut [f32],
) {
    nearest_depths_on(arch(), cpu, face, triangles, resolution, empty, texels);
}

fn nearest_depths_on(
    arch: Arch,
    cpu: &Cpu,
    face: &Face,
    triangles: &[[Vec3; 3]],
    resolution: u32,
    empty: f32,
    texels: &mut [f32],
) {
    let side = resolution as usize;
    assert_eq!(texels.len(), side * side, "one depth per texel");
    assert!(
        u32::try_from(triangles.len()).is_ok(),
        "triangles are counted in 32 bits"
    );
    let view = View {
        face,
        triangles,
        resolution,
        empty,
    };
    match face.rays {
        Rays::Parallel {
            half_width,
            half_height,
        } => {
            let projection = Parallel::new(half_width, half_height, resolution);
            view.render(arch, cpu, projection, texels);
        }
        Rays::Central { tan } => {
            view.render(arch, cpu, Central::new(tan, resolution), texels);
        }
    }
}

/// Depths from what is linear over texels, in vectors.
trait Depths: Projection {
    /// The depths in texels at `x` of a row at `y`, from the values of [`Lines::depth`].
    fn depths<S: Simd>(self, simd: S, values: S::f64s, x: S::f64s, y: f64) -> S::f64s;
}

impl Depths for Parallel {
    #[inline(always)]
    fn depths<S: Simd>(self, _: S, values: S::f64s, _: S::f64s, _: f64) -> S::f64s {
        values
    }
}

impl Depths for Central {
    #[inline(always)]
    fn depths<S: Simd>(self, simd: S, values: S::f64s, x: S::f64s, y: f64) -> S::f64s {
        let (tan, step) = (simd.splat_f64s(self.tan), simd.splat_f64s(self.step));
        let u = simd.sub_f64s(simd.mul_f64s(x, step), tan);
        let v = self.tan - y * self.step;
        let squared = simd.add_f64s(simd.mul_f64s(u, u), simd.splat_f64s(v * v));
        let length = simd.sqrt_f64s(simd.add_f64s(squared, simd.splat_f64s(1.0)));
        simd.div_f64s(length, values)
    }
}

/// What all steps share.
#[derive(Debug, Clone, Copy)]
struct View<'a> {
    face: &'a Face,
    triangles: &'a [[Vec3; 3]],
    resolution: u32,
    empty: f32,
}

impl View<'_> {
    fn render<P: Depths>(&self, arch: Arch, cpu: &Cpu, projection: P, texels: &mut [f32]) {
        let chunks = self.triangles.len().div_ceil(CHUNK);
        let sorted = cpu.map(chunks, |chunk| {
            let first = chunk * CHUNK;
            let end = self.triangles.len().min(first + CHUNK);
            let view = *self;
            arch.dispatch(Sort {
                view,
                projection,
                triangles: first as u32..end as u32,
            })
        });
        let width = self.resolution as usize;
        cpu.for_each_chunk(texels, BAND as usize * width, |first, texels| {
            let first_row = (first / width) as u32;
            let band = (first_row / BAND) as usize;
            arch.dispatch(Cover {
                view: *self,
                projection,
                triangles: sorted.iter().flat_map(|sorted| sorted.of_band(band)),
                first_row,
                texels,
            });
        });
    }
}

/// Some triangles by the bands that they may cover.
#[derive(Debug)]
struct Sorted {
    /// For each band, where its triangles begin; and the end of the last ones.
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Sorted {
    /// From triangles with the first band of each and the one after its last.
    fn new(bands: usize, spans: &[(u32, [u32; 2])]) -> Self {
        let mut starts = vec![0; bands + 1];
        for (_, [first, end]) in spans {
            for count in &mut starts[*first as usize + 1..=*end as usize] {
                *count += 1;
            }
        }
        for band in 0..bands {
            starts[band + 1] += starts[band];
        }
        let mut next = starts.clone();
        let mut triangles = vec![0; starts[bands] as usize];
        for (triangle, [first, end]) in spans {
            for place in &mut next[*first as usize..*end as usize] {
                triangles[*place as usize] = *triangle;
                *place += 1;
            }
        }
        Self { starts, triangles }
    }

    fn of_band(&self, band: usize) -> &[u32] {
        &self.triangles[self.starts[band] as usize..self.starts[band + 1] as usize]
    }
}

/// Sorts triangles with these numbers into bands.
struct Sort<'a, P> {
    view: View<'a>,
    projection: P,
    triangles: std::ops::Range<u32>,
}

impl<P: Projection> WithSimd for Sort<'_, P> {
    type Output = Sorted;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Sorted {
        let Self {
            view,
            projection,
            triangles,
        } = self;
        let mut block = Block::default();
        let mut spans = Vec::with_capacity(triangles.len());
        for first in triangles.clone().step_by(TOGETHER) {
            let numbers = first..triangles.end.min(first + TOGETHER as u32);
            for (lane, number) in numbers.clone().enumerate() {
                block.put(lane, &view.triangles[number as usize]);
            }
            block.place(view.face, projection, view.resolution);
            for (lane, number) in numbers.enumerate() {
                let [columns, rows] = &block.texels;
                if columns[0][lane] < columns[1][lane] && rows[0][lane] < rows[1][lane] {
                    let (first, end) = (rows[0][lane] as u32, rows[1][lane] as u32);
                    spans.push((number, [first / BAND, end.div_ceil(BAND)]));
                }
            }
        }
        Sorted::new(view.resolution.div_ceil(BAND) as usize, &spans)
    }
}

/// Covers the texels of a band with its triangles.
struct Cover<'a, P, I> {
    view: View<'a>,
    projection: P,
    triangles: I,
    first_row: u32,
    texels: &'a mut [f32],
}

impl<'a, P: Depths, I: Iterator<Item = &'a u32>> WithSimd for Cover<'_, P, I> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self {
            view,
            projection,
            mut triangles,
            first_row,
            texels,
        } = self;
        let width = view.resolution as usize;
        let height = texels.len() / width;
        // Vectors that begin within a row may end behind it.
        let stride = width + MOST_LANES;
        let mut band = Band {
            simd,
            projection,
            stride,
            rows: [f64::from(first_row), f64::from(first_row) + height as f64],
            depths: vec![f64::from(view.empty); stride * height],
        };
        let mut block = Block::default();
        loop {
            let mut count = 0;
            for number in triangles.by_ref().take(TOGETHER) {
                block.put(count, &view.triangles[*number as usize]);
                count += 1;
            }
            if count == 0 {
                break;
            }
            block.place(view.face, projection, view.resolution);
            block.make_lines(projection);
            for lane in 0..count {
                band.cover(&block, lane);
            }
        }
        let rows = band.depths.chunks_exact(stride);
        for (texels, depths) in texels.chunks_exact_mut(width).zip(rows) {
            for (texel, depth) in texels.iter_mut().zip(depths) {
                *texel = *depth as f32;
            }
        }
    }
}

/// A number for each triangle of a block.
type Lanes<T = f64> = [T; TOGETHER];

/// Some triangles, one in each lane. Lanes that are not filled keep what was there.
#[derive(Debug)]
#[repr(align(64))]
struct Block {
    /// Coordinates of the corners: as they come, and as the projection has placed them.
    corners: [[Lanes<f32>; 3]; 3],
    placed: [[Lanes; 3]; 3],
    is_in_front: Lanes<bool>,
    /// First and end of the columns and of the rows in which texel centres may be covered, as
    /// whole numbers.
    texels: [[Lanes; 2]; 2],
    /// Coefficients of the edges, and of the depth.
    lines: [[Lanes; 3]; 4],
    /// The reciprocals of the first coefficients of the edges, with the other sign.
    slopes: [Lanes; 3],
    determinants: Lanes,
}

impl Default for Block {
    fn default() -> Self {
        let zero = [0.0; TOGETHER];
        Self {
            corners: [[[0.0; TOGETHER]; 3]; 3],
            placed: [[zero; 3]; 3],
            is_in_front: [false; TOGETHER],
            texels: [[zero; 2]; 2],
            lines: [[zero; 3]; 4],
            slopes: [zero; 3],
            determinants: zero,
        }
    }
}

impl Block {
    #[inline(always)]
    fn put(&mut self, lane: usize, triangle: &[Vec3; 3]) {
        for (lanes, corner) in self.corners.iter_mut().zip(triangle) {
            let [x, y, z] = lanes;
            (x[lane], y[lane], z[lane]) = (corner.x, corner.y, corner.z);
        }
    }

    #[inline(always)]
    fn corners_of(&self, lane: usize) -> [DVec3; 3] {
        let [a, b, c] = &self.placed;
        let corner = |[x, y, z]: &[Lanes; 3]| DVec3::new(x[lane], y[lane], z[lane]);
        [corner(a), corner(b), corner(c)]
    }

    /// Places the corners and finds the boxes around the triangles.
    #[inline(always)]
    #[allow(
        clippy::needless_range_loop,
        reason = "steps over several arrays at once, which zipped would be unreadable"
    )]
    fn place<P: Projection>(&mut self, face: &Face, projection: P, resolution: u32) {
        let axes = [face.right, face.up, face.forward].map(|axis| axis.as_dvec3());
        let n = f64::from(resolution);
        for (corner, placed) in self.corners.iter().zip(&mut self.placed) {
            let [x, y, z] = corner;
            let [px, py, pz] = placed;
            for lane in 0..TOGETHER {
                let v = Vec3::new(x[lane], y[lane], z[lane]) - face.origin;
                let [right, up, forward] = axes.map(|axis| v.as_dvec3().dot(axis));
                let p = projection.place(DVec3::new(right, up, forward));
                (px[lane], py[lane], pz[lane]) = (p.x, p.y, p.z);
            }
        }
        for lane in 0..TOGETHER {
            let (bounds, _) = projection.box_of(self.corners_of(lane));
            self.put_texels(lane, bounds.texels(n));
        }
        for lane in 0..TOGETHER {
            self.is_in_front[lane] = projection.box_of(self.corners_of(lane)).1;
        }
        for lane in 0..TOGETHER {
            if !self.is_in_front[lane] {
                let bounds = projection.clipped_box_of(self.corners_of(lane));
                self.put_texels(
                    lane,
                    bounds.map_or([[0.0; 2]; 2], |bounds| bounds.texels(n)),
                );
            }
        }
    }

    #[inline(always)]
    fn put_texels(&mut self, lane: usize, [columns, rows]: [[f64; 2]; 2]) {
        for (lanes, [first, end]) in self.texels.iter_mut().zip([columns, rows]) {
            let [firsts, ends] = lanes;
            (firsts[lane], ends[lane]) = (first, end);
        }
    }

    #[inline(always)]
    fn make_lines<P: Projection>(&mut self, projection: P) {
        for lane in 0..TOGETHER {
            let Lines {
                edges: [first, second, third],
                depth,
                determinant,
            } = projection.lines(self.corners_of(lane));
            let all = [first, second, third, depth];
            for (lanes, line) in self.lines.iter_mut().zip(all) {
                let [a, b, c] = lanes;
                (a[lane], b[lane], c[lane]) = (line.a, line.b, line.c);
            }
            for (lanes, line) in self.slopes.iter_mut().zip(all) {
                lanes[lane] = -1.0 / line.a;
            }
            self.determinants[lane] = determinant;
        }
    }
}

/// The nearest depths so far in a band of rows.
struct Band<S, P> {
    simd: S,
    projection: P,
    stride: usize,
    /// The first row, and the one after the last.
    rows: [f64; 2],
    depths: Vec<f64>,
}

impl<S: Simd, P: Depths> Band<S, P> {
    /// Covers the texels of a triangle.
    #[inline(always)]
    fn cover(&mut self, block: &Block, lane: usize) {
        let line = |index: usize| {
            let [a, b, c] = &block.lines[index];
            Linear {
                a: a[lane],
                b: b[lane],
                c: c[lane],
            }
        };
        let lines = Lines {
            edges: [line(0), line(1), line(2)],
            depth: line(3),
            determinant: block.determinants[lane],
        };
        if !lines.cover_anything() {
            return;
        }
        let [columns, rows] = &block.texels;
        let columns = [columns[0][lane], columns[1][lane]];
        let first = rows[0][lane].max(self.rows[0]);
        let end = rows[1][lane].min(self.rows[1]);
        let slopes = [0, 1, 2].map(|edge| block.slopes[edge][lane]);
        let is_narrow = columns[1] - columns[0] <= f64::from(NARROW);
        let mut row = first;
        while row < end {
            let y = row + 0.5;
            let rests = lines.edges.map(|edge| edge.b * y + edge.c);
            let [from, to] = if is_narrow {
                columns
            } else {
                covered_columns(&lines.edges, rests, slopes, columns)
            };
            if from < to {
                self.cover_row(&lines, rests, row, [from, to]);
            }
            row += 1.0;
        }
    }

    /// Covers what a triangle covers of some columns of a row.
    #[inline(always)]
    fn cover_row(&mut self, lines: &Lines, rests: [f64; 3], row: f64, [from, to]: [f64; 2]) {
        let simd = self.simd;
        let y = row + 0.5;
        let start = (row - self.rows[0]) as usize * self.stride;
        let columns = start + from as usize..start + self.stride;
        let (vectors, _) = S::as_mut_simd_f64s(&mut self.depths[columns]);
        let count = ((to - from) as usize).div_ceil(S::F64_LANES);
        let first = Line::new(simd, lines.edges[0].a, rests[0]);
        let second = Line::new(simd, lines.edges[1].a, rests[1]);
        let third = Line::new(simd, lines.edges[2].a, rests[2]);
        let depth = Line::new(simd, lines.depth.a, lines.depth.b * y + lines.depth.c);
        let zero = simd.splat_f64s(0.0);
        let end = simd.splat_f64s(to);
        let step = simd.splat_f64s(S::F64_LANES as f64);
        let (steps, _) = S::as_simd_f64s(&STEPS);
        let mut x = simd.add_f64s(simd.splat_f64s(from + 0.5), steps[0]);
        for nearest in vectors.iter_mut().take(count) {
            let inside = simd.and_m64s(
                simd.greater_than_or_equal_f64s(first.at(simd, x), zero),
                simd.greater_than_or_equal_f64s(second.at(simd, x), zero),
            );
            let inside = simd.and_m64s(
                inside,
                simd.greater_than_or_equal_f64s(third.at(simd, x), zero),
            );
            let covered = simd.and_m64s(inside, simd.less_than_f64s(x, end));
            let depths = self.projection.depths(simd, depth.at(simd, x), x, y);
            let nearer = simd.and_m64s(covered, simd.less_than_f64s(depths, *nearest));
            *nearest = simd.select_f64s(nearer, depths, *nearest);
            x = simd.add_f64s(x, step);
        }
    }
}

/// A [`Linear`] function in a row, in vectors.
#[derive(Clone, Copy)]
struct Line<S: Simd> {
    slope: S::f64s,
    rest: S::f64s,
}

impl<S: Simd> Line<S> {
    #[inline(always)]
    fn new(simd: S, slope: f64, rest: f64) -> Self {
        Self {
            slope: simd.splat_f64s(slope),
            rest: simd.splat_f64s(rest),
        }
    }

    #[inline(always)]
    fn at(&self, simd: S, x: S::f64s) -> S::f64s {
        simd.add_f64s(simd.mul_f64s(self.slope, x), self.rest)
    }
}

/// Columns of the texels of a vector from the first one.
const STEPS: [f64; MOST_LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// The columns of a row in which all edges can be positive, wider on either side than rounding
/// may take away. `rests` are the edges at column 0.
#[inline(always)]
fn covered_columns(
    edges: &[Linear; 3],
    rests: [f64; 3],
    slopes: [f64; 3],
    [mut from, mut to]: [f64; 2],
) -> [f64; 2] {
    for ((edge, rest), slope) in edges.iter().zip(rests).zip(slopes) {
        let crossing = rest * slope;
        if edge.a > 0.0 {
            from = from.max(crossing - 1.5);
        } else if edge.a < 0.0 {
            to = to.min(crossing + 1.5);
        } else if rest < 0.0 {
            return [0.0; 2];
        }
    }
    [from.floor(), to.ceil()]
}

#[cfg(test)]
mod tests {
    use reference::random::Random;

    use super::*;
    use crate::raster::Footprint;

    const EMPTY: f32 = f32::MAX;

    fn every_arch() -> Vec<Arch> {
        let mut all = vec![Arch::Scalar];
        #[cfg(target_arch = "x86_64")]
        {
            all.extend(pulp::x86::V3::try_new().map(Arch::V3));
            all.extend(pulp::x86::V4::try_new().map(Arch::V4));
        }
        all
    }

    fn faces() -> [Face; 3] {
        let face = |rays| Face {
            origin: Vec3::new(0.1, -0.2, 0.3),
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            rays,
        };
        [
            face(Rays::Parallel {
                half_width: 2.0,
                half_height: 1.0,
            }),
            face(Rays::Central { tan: 0.8 }),
            // Corners are on the borders of texels and on their centres.
            Face {
                origin: Vec3::ZERO,
                ..face(Rays::Central { tan: 1.0 })
            },
        ]
    }

    /// Triangle by triangle.
    fn one_by_one(face: &Face, triangles: &[[Vec3; 3]], resolution: u32) -> Vec<f32> {
        let mut depths = vec![EMPTY; (resolution as usize).pow(2)];
        let all = triangles.iter();
        for footprint in all.filter_map(|triangle| Footprint::new(face, triangle, resolution)) {
            footprint.for_each(0, resolution, |x, y, depth| {
                let texel = &mut depths[(y * resolution + x) as usize];
                if depth < *texel {
                    *texel = depth;
                }
            });
        }
        depths
    }

    /// Compares the bits with those of triangles one by one.
    fn check(face: &Face, triangles: &[[Vec3; 3]], resolution: u32, context: &str) -> usize {
        let expected = one_by_one(face, triangles, resolution);
        for arch in every_arch() {
            for cpu in [Cpu::new(), Cpu::single_threaded()] {
                let mut found = vec![0.0; expected.len()];
                nearest_depths_on(arch, &cpu, face, triangles, resolution, EMPTY, &mut found);
                for (texel, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    assert_eq!(
                        found.to_bits(),
                        expected.to_bits(),
                        "{context}, {arch:?}, {face:?}, {resolution} texels, texel {texel}: \
                         {found}, expected {expected}"
                    );
                }
            }
        }
        expected.iter().filter(|depth| **depth < EMPTY).count()
    }

    /// Many reach behind the light.
    fn scattered(random: &mut Random, count: usize, extent: f32) -> Vec<[Vec3; 3]> {
        let mut next = || 6.0 * (random.unit() - 0.5);
        (0..count)
            .map(|_| {
                let centre = Vec3::new(next(), next(), next());
                [(); 3].map(|()| centre + extent * Vec3::new(next(), next(), next()))
            })
            .collect()
    }

    #[test]
    fn depths_have_the_bits_of_triangles_one_by_one() {
        let mut random = Random::new(5);
        for face in &faces() {
            for (count, extent) in [(1, 1.0), (40, 1.0), (300, 0.3), (9000, 0.01)] {
                for resolution in [1, 7, 16, 45, 200] {
                    let triangles = scattered(&mut random, count, extent);
                    let covered = check(face, &triangles, resolution, "scattered");
                    assert!(covered > 0 || count < 40 || resolution < 16);
                }
            }
        }
    }

    #[test]
    fn slivers_have_the_bits_of_triangles_one_by_one() {
        let mut random = Random::new(6);
        for face in &faces() {
            let mut triangles = scattered(&mut random, 500, 1.0);
            for (number, [a, b, c]) in triangles.iter_mut().enumerate() {
                let along = a.lerp(*b, random.unit());
                *c = match number % 4 {
                    // On the line, more or less beside it, far away along it, and at a corner.
                    0 => along,
                    1 => along + Vec3::splat(0.1_f32.powi(number as i32 / 4 % 7)),
                    2 => along + 1e4 * (*b - *a),
                    _ => *b,
                };
            }
            let covered = check(face, &triangles, 120, "slivers");
            assert!(covered > 10, "{covered}");
        }
    }

    #[test]
    fn aligned_corners_have_the_bits_of_triangles_one_by_one() {
        let mut random = Random::new(7);
        for face in &faces() {
            let mut next = || (random.below(65) as f32 - 32.0) / 16.0;
            let triangles: Vec<[Vec3; 3]> = (0..500)
                .map(|number| {
                    let z = if number % 2 == 0 { -2.0 } else { next() };
                    [(); 3].map(|()| Vec3::new(next(), next(), z))
                })
                .collect();
            for resolution in [32, 64] {
                check(face, &triangles, resolution, "aligned");
            }
        }
    }

    #[test]
    fn absurd_corners_have_the_bits_of_triangles_one_by_one() {
        let numbers = [
            0.0,
            -0.0,
            1e-45,
            1e-30,
            -1.0,
            1.0,
            1e18,
            -1e30,
            f32::MAX,
            f32::INFINITY,
            f32::NAN,
        ];
        let mut random = Random::new(8);
        let mut next = || numbers[random.below(numbers.len() as u32) as usize];
        let triangles: Vec<[Vec3; 3]> = (0..4000)
            .map(|_| [(); 3].map(|()| Vec3::new(next(), next(), next())))
            .collect();
        for face in &faces() {
            for triangle in &triangles {
                check(face, &[*triangle], 9, "absurd");
            }
            check(face, &triangles, 33, "absurd");
        }
    }

    #[test]
    fn no_triangle_leaves_all_texels_empty() {
        for face in &faces() {
            assert_eq!(check(face, &[], 20, "none"), 0);
        }
    }
}
