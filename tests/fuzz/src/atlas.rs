//! Grids of voxelized shadows and atlases of them.

use epipolar::{Lattice, Light, LightRay, Resolution, Space, Spacing, ViewVolume};
use glam::Vec3;
use gpu_backend::{Cpu, Host};
use voxel_shadow::{
    AtlasGrid, AtlasMap, BuildAtlas, BuildGrid, Grid, IndexMap, LitInterval, RectifyAtlas,
    Sampling, ShadowVolume,
};

use super::Bytes;

/// Where the eye is: lights are around it.
const EYE: Vec3 = Vec3::new(0.2, 1.7, 8.0);

/// The first of a few planes, as blockers of a light.
#[derive(Debug, Clone, Copy)]
struct Wall {
    normal: Vec3,
    /// At which distance from the origin.
    at: f32,
    /// The half-width of what there is of it, around the point next to the origin.
    half: f32,
}

impl Wall {
    fn distance(&self, ray: &LightRay) -> f32 {
        let (origin, direction) = (Vec3::from(ray.origin), Vec3::from(ray.direction));
        let distance = (self.at - self.normal.dot(origin)) / self.normal.dot(direction);
        let hit = origin + distance * direction - self.at * self.normal;
        match hit.length() < self.half {
            true => distance,
            false => f32::INFINITY,
        }
    }
}

/// A voxel is in shadow exactly if its light ray is blocked at it or before it.
fn is_brute_force(indices: &[u32], grid: &Grid<Host>) {
    let resolution = grid.resolution();
    let bits = resolution.bits() as usize;
    for (theta, indices) in (0..).zip(indices.chunks_exact(bits)) {
        for alpha in 0..resolution.alpha() {
            let word = |rays: &[u32]| {
                let bits = (0..).zip(rays);
                bits.fold(0, |word, (bit, index)| {
                    word | u32::from(*index <= alpha) << bit
                })
            };
            let expected: Vec<u32> = indices.chunks_exact(32).map(word).collect();
            assert_eq!(grid.texel(alpha, theta), expected, "({alpha}, {theta})");
        }
    }
}

fn is_in_order(lit: &[LitInterval], surface: f32) {
    let mut last = 0.0;
    for part in lit {
        let is_part = last <= part.start && part.start <= part.end && part.end <= surface;
        let is_share = part.visibility > 0.0 && part.visibility <= 1.0;
        assert!(is_part && is_share, "{lit:?} up to {surface}");
        last = part.end;
    }
}

/// Queries of a volume agree with each other, and are those of `other`.
fn ask(volumes: [&ShadowVolume<'_, Host>; 2], bytes: &mut Bytes<'_>) {
    for _ in 0..2 {
        let direction = match bytes.below(8) {
            0 => Vec3::from([(); 3].map(|()| bytes.any())),
            _ => bytes.direction(),
        };
        let surface = match bytes.below(4) {
            0 => bytes.one_of(&[f32::INFINITY, 0.0, f32::NAN, -1.0, f32::MAX]),
            _ => bytes.magnitude(-10.0, 6.0),
        };
        let [ray, other] = volumes.map(|volume| volume.ray_shadow(direction, surface));
        let fraction = ray.lit_fraction();
        assert!((0.0..=1.0).contains(&fraction), "{fraction}");
        assert_eq!(fraction, other.lit_fraction());
        let runs: Vec<LitInterval> = ray.lit_runs().collect();
        assert_eq!(runs, other.lit_runs().collect::<Vec<_>>());
        let end = surface.max(0.0);
        is_in_order(&runs, end);
        let voxels: Vec<LitInterval> = ray.lit_voxels().collect();
        is_in_order(&voxels, end);
        // Wide, so that roundings do not make the greatest distance an infinite one.
        let length = |parts: &[LitInterval]| -> f64 {
            let length = |part: &LitInterval| f64::from(part.end) - f64::from(part.start);
            let parts = parts.iter();
            parts
                .map(|part| f64::from(part.visibility) * length(part))
                .sum()
        };
        let (whole, pieces) = (length(&runs), length(&voxels));
        // Each border is rounded to its place.
        let rounding = voxels.iter();
        let rounding: f64 = rounding
            .map(|part| f64::from(f32::EPSILON) * f64::from(part.end))
            .sum();
        let is_same = whole == pieces || (whole - pieces).abs() <= 1e-5 * whole + rounding;
        assert!(is_same, "{whole} {pieces}");
        let all = ray.lit_fraction_between(0.0, surface);
        assert!((all - fraction).abs() <= 1e-5, "{all} {fraction}");
        let point = EYE + bytes.magnitude(-8.0, 6.0) * bytes.direction();
        let [found, expected] = volumes.map(|volume| volume.visibility(point));
        assert!((0.0..=1.0).contains(&found), "{found} at {point}");
        assert_eq!(found, expected);
    }
}

/// Atlases hold the bits of separate grids, these the bits of brute force over their index
/// maps, and every query of a tile is that of its grid.
///
/// # Panics
/// If not.
pub fn run(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    // Large grids have what small ones have, and take as long as many of them.
    let largest = bytes.one_of(&[6, 6, 6, 24]);
    let [alpha, theta] = [(); 2].map(|()| 1 + bytes.below(largest) as u32);
    let resolution = Resolution::new(alpha, theta, 32 * (1 + bytes.below(3) as u32));
    let resolution = resolution.expect("few voxels");
    let view = ViewVolume::perspective(Vec3::NEG_Z, Vec3::Y, [0.9, 0.6], 0.0, 20.0);
    let view = view.expect("a camera");
    let sampling = Sampling {
        interpolate: bytes.flag(),
        ..bytes.one_of(&[Sampling::UNBIASED, Sampling::PAPER, Sampling::NEAREST])
    };
    let mut lattices = Vec::new();
    let mut walls = Vec::new();
    for _ in 0..1 + bytes.below(3) {
        let light = match bytes.below(3) {
            0 => Light::directional(bytes.direction()),
            1 => Light::point(EYE + bytes.magnitude(-12.0, 8.0) * bytes.direction()),
            _ => {
                let at = EYE + bytes.magnitude(-4.0, 6.0) * bytes.direction();
                Light::spot(at, bytes.direction(), bytes.between(0.05, 3.0))
            }
        };
        let space = light.and_then(|light| Space::new(light, EYE));
        let space = space.expect("a light beside the eye");
        // A cone beside the view has no voxels in it.
        lattices.extend(Lattice::new(space, &view, resolution, Spacing::Angle));
        walls.push(Wall {
            normal: bytes.direction(),
            at: bytes.between(-4.0, 8.0),
            half: bytes.magnitude(-3.0, 4.0),
        });
    }
    let cpu = Cpu::single_threaded();
    let (tiles, rays) = (lattices.len(), resolution.light_rays());
    let mut map = AtlasMap::new(&cpu, resolution, tiles).expect("few tiles");
    let blocker = |tile: usize, ray: &LightRay| walls[tile].distance(ray);
    (cpu.rectify_atlas(&lattices, &blocker, &mut map)).expect("as many tiles as lights");
    assert!(map.indices().iter().all(|index| *index <= alpha));
    if bytes.flag() {
        // Any entries at all instead.
        let mut indices = map.indices().clone();
        for index in &mut indices {
            *index = match bytes.byte() {
                0..200 => *index,
                200..210 => bytes.word(),
                byte => u32::from(byte) % (alpha + 2),
            };
        }
        map = AtlasMap::from_indices(resolution, tiles, indices).expect("as many as before");
    }
    let mut atlas = AtlasGrid::new(&cpu, resolution, tiles).expect("few tiles");
    cpu.build_atlas(&map, tiles, &mut atlas)
        .expect("as many tiles");
    // Queries take the most time: of one tile.
    let asked = bytes.below(tiles.max(1));
    for (tile, lattice) in lattices.iter().enumerate() {
        let own = map.indices()[tile * rays..][..rays].to_vec();
        let one = IndexMap::from_indices(resolution, own.clone()).expect("as many rays");
        let mut grid = Grid::new(&cpu, resolution).expect("few voxels");
        cpu.voxelise(&one, &mut grid).expect("the same resolution");
        cpu.extrude(&mut grid).expect("a grid");
        is_brute_force(&own, &grid);
        let words = resolution.words();
        assert_eq!(&atlas.words()[tile * words..][..words], &grid.words()[..]);
        if tile == asked {
            let alone = ShadowVolume::new(lattice, &grid, sampling).expect("the same resolution");
            let tile = atlas.volume(tile, lattice, sampling).expect("a tile");
            ask([&alone, &tile], &mut bytes);
        }
    }
}

/// Lights and walls of every kind.
pub fn seeds() -> Vec<Vec<u8>> {
    (0..24_u8)
        .map(|seed| {
            let mix = |i: u8| i.wrapping_mul(73) ^ seed.wrapping_mul(59).rotate_left(5);
            (0..200_u8).map(mix).collect()
        })
        .collect()
}
