use glam::IVec3;
use gpu_backend::Cpu;
use proptest::prelude::*;

use super::maps::{self, Map};
use crate::graph::Graph;
use crate::pool::{LIT, Pool, Reference, SHADOWED, is_mixed};
use crate::rule::Tile;
use crate::{
    Builder, DepthMap, DepthSource, Error, Exits, Form, Resolution, Rule, Slices, TileRect,
};

const RULES: [Rule; 3] = [Rule::Sintorn2014, Rule::Kampe2015, Rule::Aligned];

/// Every voxel of the grid, in both forms, against the map.
fn agrees(map: &Map, builder: Builder) -> Result<(), TestCaseError> {
    let dag = builder.build(&Cpu::new(), map).unwrap();
    let packed = dag.to_form(Form::Packed).unwrap();
    let n = map.side();
    for z in 0..n {
        for y in 0..n {
            for x in 0..n {
                let voxel = IVec3::new(x as i32, y as i32, z as i32);
                let lit = dag.is_lit(voxel);
                if let Some(expected) = map.defined(x, y, z) {
                    prop_assert_eq!(lit, expected, "{} with {:?}", voxel, builder);
                }
                prop_assert_eq!(packed.is_lit(voxel), lit, "{} packed", voxel);
            }
        }
    }
    Ok(())
}

pub(crate) fn no_two_equal(graph: &Graph) {
    let mut masks = graph.masks.clone();
    masks.sort_unstable();
    masks.dedup();
    assert_eq!(masks.len(), graph.masks.len());
    for level in &graph.levels {
        let mut nodes = level.clone();
        nodes.sort_unstable();
        nodes.dedup();
        assert_eq!(nodes.len(), level.len());
        for node in level {
            let same = node.iter().all(|child| child == &node[0]);
            assert!(!same || is_mixed(node[0]), "a homogeneous node");
        }
    }
}

/// The nodes by the definition: top-down, every volume on its own.
fn top_down(map: &Map, rule: Rule) -> Graph {
    fn bounds(map: &Map, x: u32, y: u32, size: u32) -> (u32, u32) {
        let texels = (0..size * size).map(|i| map.texel(x + i % size, y + i / size));
        texels.fold((0, u32::MAX), |(enter, exit), [e, x]| {
            (enter.max(e), exit.min(x))
        })
    }
    fn volume(
        map: &Map,
        rule: Rule,
        pool: &mut Pool,
        level: usize,
        [x, y, z]: [u32; 3],
    ) -> Reference {
        let size = 8 << level;
        let (enter, exit) = bounds(map, x, y, size);
        if z + size <= exit {
            return LIT;
        }
        if z >= enter {
            return SHADOWED;
        }
        let mut children = [LIT; 8];
        if level > 0 {
            for (i, child) in (0..).zip(&mut children) {
                let at = [
                    x + (i & 1) * size / 2,
                    y + (i >> 1 & 1) * size / 2,
                    z + (i >> 2) * size / 2,
                ];
                *child = volume(map, rule, pool, level - 1, at);
            }
            return pool.node(level, children);
        }
        let mut tile = Tile::default();
        for i in 0..64 {
            [tile.enter[i], tile.exit[i]] = map.texel(x + i as u32 % 8, y + i as u32 / 8);
        }
        for (z, child) in (z..).zip(&mut children) {
            *child = pool.mask(mask(&tile, rule, z));
        }
        pool.node(0, children)
    }
    /// Slice by slice from the front.
    fn mask(tile: &Tile, rule: Rule, z: u32) -> u64 {
        if rule == Rule::Sintorn2014 {
            let first_exit = tile.exit.iter().min().unwrap();
            let lit = (0..64).filter(|&i| z < tile.enter[i] || z < *first_exit);
            return lit.fold(0, |mask, i| mask | 1 << i);
        }
        let mut lit = u64::MAX;
        for slice in 0..=z {
            let must_change = (0..64).any(|i| lit >> i & 1 == 1 && tile.exit[i] <= slice);
            if must_change {
                for i in 0..64 {
                    if tile.enter[i] <= slice {
                        lit &= !(1 << i);
                    }
                }
            }
        }
        lit
    }
    let mut pool = Pool::new(map.resolution);
    let root = volume(map, rule, &mut pool, map.resolution.root_level(), [0; 3]);
    Graph::collect(map.resolution, &pool, root)
}

#[test]
fn named_maps_are_answered_voxel_by_voxel() {
    for side in [8, 16, 32, 64] {
        for (name, map) in maps::named(side) {
            for map in [map.clone(), map.open()] {
                for rule in RULES {
                    agrees(&map, Builder::new().rule(rule)).unwrap_or_else(|error| {
                        panic!("{name} at {side}: {error}");
                    });
                }
            }
        }
    }
}

#[test]
fn a_lit_slice_with_one_shadow_is_not_eight_of_another_kind() {
    // The two kinds of nodes that have the same words once lit, shadowed and
    // the number of a mask are mixed up: one lit slice of mask 0x0001, and
    // eight masks of number 1.
    let mut pool = Pool::new(Resolution::new(8).unwrap());
    let (first, second) = (pool.mask(1), pool.mask(2));
    assert_eq!((first, second), (0, 1));
    let nodes = [
        [
            LIT, first, SHADOWED, SHADOWED, SHADOWED, SHADOWED, SHADOWED, SHADOWED,
        ],
        [second; 8],
        [first; 8],
        [LIT, first, first, first, first, first, first, first],
    ];
    assert_eq!(nodes.map(|children| pool.node(0, children)), [0, 1, 2, 3]);
    let map = Map::new(16, |x, y| match (x / 8, y / 8) {
        (0, 0) => {
            if (x, y) == (0, 0) {
                [2; 2]
            } else {
                [1; 2]
            }
        }
        (1, 0) => {
            if (x, y) == (9, 0) {
                [16; 2]
            } else {
                [0; 2]
            }
        }
        _ => [3; 2],
    });
    agrees(&map, Builder::new()).unwrap();
}

proptest! {
    #![proptest_config(reference::property::cases(24))]

    #[test]
    fn every_voxel_is_answered(
        map in prop_oneof![
            maps::arbitrary(8), maps::arbitrary(32), maps::arbitrary(64),
            maps::noise(8), maps::noise(16),
        ],
        rule in proptest::sample::select(&RULES[..]),
    ) {
        agrees(&map, Builder::new().rule(rule))?;
    }

    #[test]
    fn columns_give_the_nodes_of_a_descent_volume_by_volume(
        map in prop_oneof![maps::arbitrary(32), maps::arbitrary(128), maps::noise(32)],
        rule in proptest::sample::select(&RULES[..2]),
        culling: bool,
    ) {
        let built = Builder::new().rule(rule).culling(culling);
        let graph = built.graph(&Cpu::new(), &map).unwrap();
        prop_assert!(graph == top_down(&map, rule), "{:?}", built);
    }

    #[test]
    fn culling_changes_nothing_and_no_two_nodes_are_equal(
        map in prop_oneof![maps::arbitrary(128), maps::noise(32)],
    ) {
        for rule in RULES {
            let builder = Builder::new().rule(rule);
            let graph = builder.graph(&Cpu::new(), &map).unwrap();
            no_two_equal(&graph);
            let all = builder.culling(false).graph(&Cpu::new(), &map).unwrap();
            prop_assert!(graph == all, "{:?}", rule);
        }
    }

    #[test]
    fn the_aligned_rule_lets_every_texel_turn_once(map in maps::arbitrary(64)) {
        let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
        for texel in 0..64 * 64 {
            let (x, y) = (texel % 64, texel / 64);
            let lit: Vec<bool> = (0..64).map(|z| dag.is_lit(IVec3::new(x, y, z))).collect();
            let turns = lit.windows(2).filter(|pair| pair[0] != pair[1]).count();
            prop_assert!(turns <= 1 && (turns == 0 || lit[0]), "({}, {})", x, y);
        }
    }
}

/// A large map as a function, so that regions meet.
pub(crate) struct Hills(pub(crate) Resolution);

impl Hills {
    fn texel(&self, x: u32, y: u32) -> [u32; 2] {
        let n = self.0.side();
        let wave = ((x as f32 * 0.01).sin() * (y as f32 * 0.013).cos() + 1.0) * 0.4;
        let tower = (x / 37).is_multiple_of(3) && y / 53 % 4 == 1;
        let enter = (wave * n as f32) as u32 / if tower { 2 } else { 1 };
        [enter, (enter + if tower { 40 } else { 7 }).min(n)]
    }
}

impl DepthSource for Hills {
    fn resolution(&self) -> Resolution {
        self.0
    }

    fn read(&self, tile: TileRect, enter: &mut [u32], exit: &mut [u32]) -> Result<Exits, Error> {
        for at in 0..tile.len() {
            let (x, y) = (at as u32 % tile.side, at as u32 / tile.side);
            [enter[at], exit[at]] = self.texel(tile.x + x, tile.y + y);
        }
        Ok(Exits::Closed)
    }
}

#[test]
fn many_regions_give_one_result_on_any_number_of_threads() {
    let hills = Hills(Resolution::new(2048).unwrap());
    let single = Builder::new()
        .build(&Cpu::single_threaded(), &hills)
        .unwrap();
    let many = Builder::new().build(&Cpu::new(), &hills).unwrap();
    assert!(single.as_bytes() == many.as_bytes());
    #[cfg(feature = "rayon")]
    {
        let five = Builder::new()
            .build(&Cpu::with_threads(5).unwrap(), &hills)
            .unwrap();
        assert!(single.as_bytes() == five.as_bytes());
    }
    no_two_equal(&single.graph());
    let packed = single.to_form(Form::Packed).unwrap();
    // Voxels around both ends of the intervals of many texels.
    for i in 0..100_000_u32 {
        let (x, y) = (
            i.wrapping_mul(2_654_435_761) >> 21,
            i.wrapping_mul(40_503) % 2048,
        );
        let [enter, exit] = hills.texel(x, y);
        for (z, lit) in [(0, enter > 0), (enter, false), (exit, false), (2047, false)] {
            let at = |z: u32| IVec3::new(x as i32, y as i32, z as i32);
            if z >= exit {
                assert_eq!(single.is_lit(at(z)), lit, "({x}, {y}, {z})");
                assert_eq!(packed.is_lit(at(z)), lit, "({x}, {y}, {z}) packed");
            }
            if enter > 0 {
                assert!(single.is_lit(at(enter - 1)) && packed.is_lit(at(enter - 1)));
            }
        }
    }
}

#[test]
fn depths_become_slices_as_if_centres_were_compared() {
    let resolution = Resolution::new(16).unwrap();
    let depths: Vec<f32> = (0..256).map(|i| i as f32 / 200.0 - 0.1).collect();
    let map = DepthMap::new(resolution, Slices::Linear, &depths).unwrap();
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    for (i, &depth) in depths.iter().enumerate() {
        for z in 0..16 {
            let centre = (z as f32 + 0.5) / 16.0;
            let voxel = IVec3::new(i as i32 % 16, i as i32 / 16, z);
            assert_eq!(dag.is_lit(voxel), centre < depth, "{voxel} of {depth}");
        }
    }
}

#[test]
fn infinite_depths_are_nothing_and_nan_is_an_error() {
    let resolution = Resolution::new(8).unwrap();
    let mut depths = vec![f32::INFINITY; 64];
    depths[0] = f32::NEG_INFINITY;
    let dag = |depths: &[f32]| {
        let map = DepthMap::new(resolution, Slices::Linear, depths)?;
        Builder::new().build(&Cpu::new(), &map)
    };
    let built = dag(&depths).unwrap();
    assert!(!built.is_lit(IVec3::ZERO));
    assert!(built.is_lit(IVec3::new(1, 0, 7)));
    depths[10] = f32::NAN;
    let error = dag(&depths).unwrap_err();
    assert!(
        matches!(error, Error::NotANumber { x: 2, y: 1, .. }),
        "{error}"
    );
    let error = dag(&depths[1..]).unwrap_err();
    assert!(matches!(error, Error::Length { given: 63, .. }), "{error}");
}

#[test]
fn the_error_of_a_source_stops_the_build() {
    struct Broken;
    impl DepthSource for Broken {
        fn resolution(&self) -> Resolution {
            Resolution::new(2048).unwrap()
        }
        fn read(&self, tile: TileRect, _: &mut [u32], _: &mut [u32]) -> Result<Exits, Error> {
            let source = Box::new(std::io::Error::other("gone"));
            Err(Error::Source {
                x: tile.x,
                y: tile.y,
                source,
            })
        }
    }
    let error = Builder::new().build(&Cpu::new(), &Broken).unwrap_err();
    assert!(matches!(error, Error::Source { x: 0, y: 0, .. }), "{error}");
}

#[test]
fn tiles_that_are_none_are_errors() {
    let resolution = Resolution::new(64).unwrap();
    let depths = vec![0.5; 64 * 64];
    let map = DepthMap::new(resolution, Slices::Linear, &depths).unwrap();
    let light = crate::LightSpace::of_voxels(resolution);
    let mesh = crate::Mesh::new(resolution, light, &[], &[]).unwrap();
    let casters: [&dyn DepthSource; 2] = [&map, &mesh];
    for casters in casters {
        let read = |x, y, side: u32, places: usize| {
            let (mut enter, mut exit) = (vec![0; places], vec![0; places]);
            casters.read(TileRect { x, y, side }, &mut enter, &mut exit)
        };
        assert!(read(16, 32, 16, 256).is_ok());
        for (x, y, side) in [
            (0, 0, 0),
            (0, 0, 4),
            (0, 0, 24),
            (0, 0, 128),
            (8, 0, 16),
            (0, 64, 16),
            (u32::MAX - 15, 0, 16),
        ] {
            let error = read(x, y, side, 256).unwrap_err();
            assert!(matches!(error, Error::BadValue { .. }), "{error}");
        }
        let error = read(0, 0, 16, 255).unwrap_err();
        assert!(
            matches!(
                error,
                Error::Length {
                    given: 255,
                    expected: 256,
                    ..
                }
            ),
            "{error}"
        );
    }
}

#[test]
fn resolutions_are_powers_of_two_within_limits() {
    for bad in [0, 1, 4, 7, 9, 100, 1 << 21, u32::MAX] {
        assert!(
            matches!(Resolution::new(bad), Err(Error::Resolution(_))),
            "{bad}"
        );
    }
    for log2 in 3..=20 {
        assert_eq!(Resolution::new(1 << log2).unwrap().side(), 1 << log2);
    }
}

#[test]
fn shadowed_is_the_only_kind_beside_lit_that_names_no_node() {
    assert!(!is_mixed(LIT) && !is_mixed(SHADOWED) && is_mixed(SHADOWED - 1));
}
