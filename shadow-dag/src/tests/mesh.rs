use std::sync::Arc;

use glam::dcamera::rh::view::look_at_mat4;
use glam::{DMat4, DQuat, DVec3, IVec3, UVec2, Vec3};
use gpu_backend::Cpu;
use proptest::prelude::*;
use reference::random::Random;

use super::bake::threads;
use super::build::no_two_equal;
use crate::{
    Builder, DepthSource, Error, Holes, LightSpace, Mesh, Resolution, Rule, ShadowDag, Surfaces,
    TileRect, Watertightness,
};

/// A turned box.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Solid {
    pub(crate) centre: DVec3,
    pub(crate) half: DVec3,
    pub(crate) turn: DQuat,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct Soup {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) indices: Vec<[u32; 3]>,
}

impl Soup {
    fn solid(&mut self, solid: &Solid) {
        let first = self.positions.len() as u32;
        for corner in 0..8 {
            let sign = |bit: u32| if corner >> bit & 1 == 1 { 1.0 } else { -1.0 };
            let at = solid.half * DVec3::new(sign(0), sign(1), sign(2));
            self.positions
                .push((solid.centre + solid.turn * at).as_vec3());
        }
        // Each face with its corners counter-clockwise from outside.
        for [a, b, c, d] in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ] {
            self.indices.push([first + a, first + b, first + c]);
            self.indices.push([first + a, first + c, first + d]);
        }
    }

    pub(crate) fn of(solids: &[Solid]) -> Self {
        let mut soup = Self::default();
        solids.iter().for_each(|solid| soup.solid(solid));
        soup
    }

    pub(crate) fn mesh(&self, resolution: u32, light: LightSpace) -> Mesh {
        let resolution = Resolution::new(resolution).unwrap();
        Mesh::new(
            resolution,
            light,
            bytemuck::cast_slice(&self.positions),
            &self.indices,
        )
        .unwrap()
    }
}

pub(crate) fn solid() -> impl Strategy<Value = Solid> {
    // Some stand on a lattice and touch, some are turned at random.
    let free = (
        (-0.5_f64..0.5, -0.5_f64..0.5, -0.5_f64..0.5),
        (0.002_f64..0.4, 0.002_f64..0.4, 0.002_f64..0.4),
        (-3.0_f64..3.0, -3.0_f64..3.0, -3.0_f64..3.0),
    )
        .prop_map(|(centre, half, turn)| Solid {
            centre: centre.into(),
            half: half.into(),
            turn: DQuat::from_scaled_axis(turn.into()),
        });
    let lattice = ((-2..3, -2..3, -2..3), (1..4, 1..4, 1..4)).prop_map(|(centre, half)| {
        let vector = |(x, y, z): (i32, i32, i32)| IVec3::new(x, y, z).as_dvec3();
        Solid {
            centre: vector(centre) / 8.0,
            half: vector(half) / 16.0,
            turn: DQuat::IDENTITY,
        }
    });
    prop_oneof![free, lattice]
}

pub(crate) fn lights() -> [LightSpace; 4] {
    let from = |eye: DVec3| look_at_mat4(eye, DVec3::ZERO, DVec3::Y);
    let slanted = from(DVec3::new(1.0, 2.0, 0.7));
    let straight = from(DVec3::new(0.0, 0.0, 2.0));
    [
        LightSpace::orthographic(slanted, 1.6, 1.4, 0.5, 4.0).unwrap(),
        LightSpace::orthographic(straight, 1.0, 1.0, 1.0, 3.0).unwrap(),
        LightSpace::perspective(slanted, 0.7, 1.0, 5.0).unwrap(),
        // Inside of the scene: things are cut off, and behind the light.
        LightSpace::perspective(from(DVec3::new(0.1, 0.2, 0.15)), 2.0, 0.05, 3.0).unwrap(),
    ]
}

/// Enter and exit slices of the whole map.
fn map(mesh: &Mesh) -> Vec<[u32; 2]> {
    let side = mesh.resolution().side();
    let tile = TileRect { x: 0, y: 0, side };
    let (mut enter, mut exit) = (vec![0; tile.len()], vec![0; tile.len()]);
    mesh.read(tile, &mut enter, &mut exit).unwrap();
    enter
        .into_iter()
        .zip(exit)
        .map(|(enter, exit)| [enter, exit])
        .collect()
}

fn between(dag: &ShadowDag, map: &[[u32; 2]]) -> Result<(), TestCaseError> {
    let side = dag.resolution().side();
    for (i, &[enter, exit]) in (0..).zip(map) {
        let (x, y) = (i % side, i / side);
        let depth = dag.depth(UVec2::new(x, y));
        prop_assert!(
            (enter..=exit).contains(&depth),
            "({}, {}): {} in [{}, {}]",
            x,
            y,
            depth,
            enter,
            exit
        );
        let lit = |z: u32| dag.is_lit(IVec3::new(x as i32, y as i32, z as i32));
        prop_assert!(enter == 0 || lit(enter - 1));
        prop_assert!(exit == side || !lit(exit));
    }
    Ok(())
}

/// The first stretch inside of any solid along the ray of a texel, in slices
/// as real numbers; moved by a part of a texel.
fn stretch(solids: &[Solid], light: &LightSpace, side: u32, at: [f64; 2]) -> Option<[f64; 2]> {
    let inverse = light.matrix().inverse();
    let point = |depth: f64| {
        inverse.transform_point3(DVec3::new(
            at[0] / f64::from(side),
            at[1] / f64::from(side),
            depth,
        ))
    };
    let (origin, direction) = (point(0.0), point(1.0) - point(0.0));
    let mut inside: Vec<[f64; 2]> = (solids.iter())
        .filter_map(|solid| {
            let back = solid.turn.inverse();
            let (o, d) = (back * (origin - solid.centre), back * direction);
            let mut stretch = [f64::NEG_INFINITY, f64::INFINITY];
            for i in 0..3 {
                let (a, b) = (
                    (-solid.half[i] - o[i]) / d[i],
                    (solid.half[i] - o[i]) / d[i],
                );
                stretch = [stretch[0].max(a.min(b)), stretch[1].min(a.max(b))];
            }
            (stretch[0] < stretch[1]).then_some(stretch)
        })
        .collect();
    inside.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut union = *inside.first()?;
    for next in inside {
        if next[0] <= union[1] {
            union[1] = union[1].max(next[1]);
        }
    }
    Some(union.map(|depth| depth * f64::from(side) - 0.5))
}

proptest! {
    #![proptest_config(reference::property::cases(60))]

    #[test]
    fn a_bake_lies_between_enter_and_exit_of_its_maps(
        solids in proptest::collection::vec(solid(), 0..10),
        removed in proptest::collection::vec(any::<prop::sample::Index>(), 0..2),
        light in proptest::sample::select(lights().to_vec()),
        side in proptest::sample::select(&[8_u32, 64, 128][..]),
    ) {
        let mut soup = Soup::of(&solids);
        for triangle in removed {
            if !soup.indices.is_empty() {
                soup.indices.swap_remove(triangle.index(soup.indices.len()));
            }
        }
        let mesh = soup.mesh(side, light);
        let map = map(&mesh);
        let baked = Builder::new().bake(&Cpu::new(), &mesh).unwrap();
        no_two_equal(&baked.graph());
        between(&baked, &map)?;
        between(&Builder::new().build(&Cpu::new(), &mesh).unwrap(), &map)?;
        between(&Builder::new().rule(Rule::Kampe2015).bake(&Cpu::new(), &mesh).unwrap(), &map)?;
    }

    #[test]
    fn maps_are_the_union_of_the_solids(
        solids in proptest::collection::vec(solid(), 1..8),
        light in proptest::sample::select(lights()[..2].to_vec()),
    ) {
        let side = 64;
        let mesh = Soup::of(&solids).mesh(side, light);
        prop_assert!(mesh.watertightness().is_closed());
        let mut compared = 0;
        for (i, texel) in map(&mesh).into_iter().enumerate() {
            let [x, y] = [i as u32 % side, i as u32 / side].map(|i| f64::from(i) + 0.5);
            // Rays so close to an edge that corners in f32 may be on its
            // other side, or to a place where solids touch, say nothing.
            let around = [(0.0, 0.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
                .map(|(dx, dy)| stretch(&solids, &light, side, [x + 1e-3 * dx, y + 1e-3 * dy]));
            let none = around.iter().all(Option::is_none);
            let all: Vec<[f64; 2]> = around.iter().copied().flatten().collect();
            let spread = |k: usize| {
                all.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], s| [a.min(s[k]), b.max(s[k])])
            };
            if none {
                prop_assert_eq!(texel, [side; 2]);
            } else if all.len() == 5 && (0..2).all(|k| spread(k)[1] - spread(k)[0] < 0.5) {
                compared += 1;
                for (k, &found) in texel.iter().enumerate() {
                    let [low, high] = spread(k).map(|z| z.ceil().clamp(0.0, f64::from(side)));
                    let found = f64::from(found);
                    prop_assert!((low..=high).contains(&found), "{} {}: {} of {:?}", x, y, found, around);
                }
            }
        }
        prop_assume!(compared > 0);
    }
}

#[test]
fn nothing_casts_no_shadow() {
    let mesh = Soup::default().mesh(64, lights()[0]);
    assert_eq!(mesh.watertightness(), Watertightness::default());
    let dag = Builder::new().bake(&Cpu::new(), &mesh).unwrap();
    assert!(map(&mesh).iter().all(|texel| *texel == [64; 2]));
    assert!(dag.is_lit(IVec3::new(3, 4, 63)));
    assert_eq!(dag.light(), Some(&lights()[0]));
}

#[test]
fn a_mesh_with_a_hole_is_open_and_casts_the_same_shadow() {
    let solid = Solid {
        centre: DVec3::ZERO,
        half: DVec3::new(0.3, 0.2, 0.1),
        turn: DQuat::from_rotation_x(0.4),
    };
    let light = lights()[0];
    let mut soup = Soup::of(&[solid]);
    let closed = soup.mesh(64, light);
    assert_eq!(
        closed.watertightness(),
        Watertightness {
            parts: 1,
            ..Watertightness::default()
        }
    );
    // Without one triangle of the far side.
    let far = (0..12).max_by_key(|&i| {
        let z: f64 = soup.indices[i]
            .map(|k| {
                light
                    .voxel(Resolution::new(64).unwrap(), soup.positions[k as usize])
                    .unwrap()
                    .z
            })
            .iter()
            .sum();
        (z * 1e6) as i64
    });
    soup.indices.remove(far.unwrap());
    let open = soup.mesh(64, light);
    let expected = Watertightness {
        parts: 1,
        open_parts: 1,
        open_edges: 3,
        inverted_parts: 0,
    };
    assert_eq!(open.watertightness(), expected);
    for (closed, open) in map(&closed).into_iter().zip(map(&open)) {
        assert_eq!(open, [closed[0]; 2]);
    }
}

#[test]
fn a_solid_turned_inside_out_still_casts_a_shadow() {
    let solid = Solid {
        centre: DVec3::ZERO,
        half: DVec3::splat(0.2),
        turn: DQuat::IDENTITY,
    };
    let mut soup = Soup::of(&[solid]);
    let right = map(&soup.mesh(64, lights()[1]));
    for corners in &mut soup.indices {
        corners.swap(0, 1);
    }
    let mesh = soup.mesh(64, lights()[1]);
    assert_eq!(mesh.watertightness().inverted_parts, 1);
    assert!(!mesh.watertightness().is_closed());
    for (right, inverted) in right.into_iter().zip(map(&mesh)) {
        assert_eq!(inverted, [right[0]; 2]);
    }
}

#[test]
fn a_light_inside_of_a_solid_begins_in_shadow() {
    let solid = Solid {
        centre: DVec3::ZERO,
        half: DVec3::splat(0.4),
        turn: DQuat::IDENTITY,
    };
    let view = DMat4::IDENTITY;
    for light in [
        LightSpace::perspective(view, 0.5, 0.1, 2.0).unwrap(),
        LightSpace::orthographic(view, 0.2, 0.2, 0.0, 1.0).unwrap(),
    ] {
        let mesh = Soup::of(&[solid]).mesh(64, light);
        let depth = if *light.slices() == crate::Slices::Linear {
            0.4
        } else {
            4_f64.ln() / 20_f64.ln()
        };
        let exit = (64.0 * depth - 0.5).ceil() as u32;
        for texel in map(&mesh) {
            assert_eq!(texel, [0, exit]);
        }
        between(
            &Builder::new().bake(&Cpu::new(), &mesh).unwrap(),
            &map(&mesh),
        )
        .unwrap();
    }
}

#[test]
fn a_bake_at_the_highest_resolutions_agrees_with_single_tiles() {
    let solids: Vec<Solid> = (0..5)
        .map(|i| Solid {
            centre: DVec3::new(f64::from(i) - 2.0, 0.3 * f64::from(i % 2), -0.2) * 0.15,
            half: DVec3::new(0.05, 0.03, 0.08),
            turn: DQuat::from_rotation_y(f64::from(i)),
        })
        .collect();
    for (log2, light) in [(14, lights()[0]), (14, lights()[2]), (20, lights()[1])] {
        let mesh = Soup::of(&solids[..if log2 == 20 { 1 } else { 5 }]).mesh(1 << log2, light);
        let cpu = Cpu::new();
        let dag = Builder::new().bake(&cpu, &mesh).unwrap();
        if log2 == 14 {
            let single = Builder::new().bake(&Cpu::single_threaded(), &mesh).unwrap();
            assert!(single.as_bytes() == dag.as_bytes());
        }
        let tiles = (1_u32 << log2) / 8;
        for i in 0..400_u32 {
            let spread = |salt: u32| i.wrapping_mul(salt) >> (32 - log2 + 3);
            let (x, y) = (
                8 * (spread(2_654_435_761) % tiles),
                8 * (spread(2_246_822_519) % tiles),
            );
            let tile = TileRect { x, y, side: 8 };
            let (mut enter, mut exit) = ([0; 64], [0; 64]);
            mesh.read(tile, &mut enter, &mut exit).unwrap();
            for k in 0..64 {
                let depth = dag.depth(UVec2::new(x + k % 8, y + k / 8));
                let k = k as usize;
                assert!((enter[k]..=exit[k]).contains(&depth), "{x} {y} {k}");
            }
        }
    }
}

#[test]
fn meshes_that_are_none_are_errors() {
    let resolution = Resolution::new(64).unwrap();
    let new = |positions: &[Vec3], indices: &[[u32; 3]]| {
        Mesh::new(
            resolution,
            lights()[0],
            bytemuck::cast_slice(positions),
            indices,
        )
        .map(|_| ())
    };
    let error = new(&[Vec3::ZERO; 2], &[[0, 1, 0], [0, 1, 2]]).unwrap_err();
    assert!(
        matches!(
            error,
            Error::NoSuchVertex {
                triangle: 1,
                vertex: 2,
                vertices: 2
            }
        ),
        "{error}"
    );
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for axis in 0..3 {
            let mut at = [0.0; 3];
            at[axis] = bad;
            let error = new(&[Vec3::ONE, Vec3::ZERO, at.into(), at.into()], &[]).unwrap_err();
            assert!(
                matches!(error, Error::NotFinite { vertex: 2, .. }),
                "{error}"
            );
            assert!(error.to_string().starts_with("vertex 2 is at ["), "{error}");
        }
    }
    // Far away, huge, tiny and without area.
    let far = [
        Vec3::splat(f32::MAX),
        Vec3::splat(f32::MIN),
        Vec3::X,
        Vec3::splat(1e-40),
        Vec3::ZERO,
    ];
    for light in lights() {
        let mesh = Mesh::new(
            resolution,
            light,
            bytemuck::cast_slice(&far),
            &[[0, 1, 2], [2, 3, 4], [4, 4, 4], [0, 2, 4]],
        );
        let dag = Builder::new().bake(&Cpu::new(), &mesh.unwrap()).unwrap();
        let _ = dag.is_lit(IVec3::splat(3));
    }
}
#[test]
fn triangles_in_any_part_of_a_texel_count_where_texels_are_large() {
    // The last texel of 8 has 8 of the bins by which triangles are found. A
    // face of the second solid is in the last of them only.
    let upright = |centre: DVec3, half: DVec3| Solid {
        centre,
        half,
        turn: DQuat::IDENTITY,
    };
    let solids = [
        upright(DVec3::ZERO, DVec3::new(0.3202, 0.228, 0.3021)),
        upright(
            DVec3::new(0.25, -0.25, 0.125),
            DVec3::new(0.1875, 0.125, 0.0625),
        ),
    ];
    let mesh = Soup::of(&solids).mesh(8, lights()[3]);
    let map = map(&mesh);
    // The light is inside of the first solid: all rays begin in shadow.
    assert!(map.iter().all(|[enter, _]| *enter == 0), "{map:?}");
    let baked = Builder::new().bake(&Cpu::new(), &mesh).unwrap();
    between(&baked, &map).unwrap();
}

/// Holes where the weight of the first corner is less than this.
#[derive(Debug)]
pub(crate) struct Beyond(pub(crate) f64);

impl Holes for Beyond {
    fn is_hole(&self, _: u32, u: f64, v: f64) -> bool {
        1.0 - u - v < self.0
    }

    fn describe(&self, word: &mut dyn FnMut(u64)) {
        word(self.0.to_bits());
    }
}

#[test]
fn a_triangle_with_a_hole_is_the_triangle_that_is_left_of_it() {
    let resolution = Resolution::new(128).unwrap();
    let [a, b, c] = [
        Vec3::new(0.05, 0.4, 0.1),
        Vec3::new(-0.4, -0.5, 0.0),
        Vec3::new(0.5, -0.3, 0.3),
    ];
    let corners = |points: [Vec3; 3]| points.map(|point| point.to_array()).to_vec();
    for light in lights() {
        let whole = Surfaces::new(corners([a, b, c]), vec![[0, 1, 2]]).unwrap();
        let masked = |share| whole.clone().with_holes(&[0], Arc::new(Beyond(share)));
        let half = masked(0.5).seen_from(light, resolution);
        assert!(half.has_holes());
        let left = corners([a, 0.5 * (a + b), 0.5 * (a + c)]);
        let left = Mesh::new(resolution, light, &left, &[[0, 1, 2]]).unwrap();
        let (found, expected) = (map(&half), map(&left));
        let apart = |(a, b): (&[u32; 2], &[u32; 2])| a[0].abs_diff(b[0]) > 1;
        let others = found
            .iter()
            .zip(&expected)
            .filter(|pair| apart(*pair))
            .count();
        // Corners are snapped: texels on the rim may be on either side.
        assert!(others <= 2, "{others}");
        let baked = Builder::new().bake(&Cpu::new(), &half).unwrap();
        between(&baked, &found).unwrap();
        // Another hole is another bake.
        let other = masked(0.4).seen_from(light, resolution);
        assert_ne!(half.identity(), other.identity());
        assert_ne!(
            half.identity(),
            whole.seen_from(light, resolution).identity()
        );
    }
}

#[test]
fn a_solid_with_a_hole_encloses_nothing() {
    let soup = Soup::of(&[Solid {
        centre: DVec3::ZERO,
        half: DVec3::splat(0.2),
        turn: DQuat::IDENTITY,
    }]);
    let surfaces = Surfaces::new(bytemuck::cast_slice(&soup.positions), &soup.indices[..]).unwrap();
    assert!(surfaces.watertightness().is_closed());
    let holes = Arc::new(Beyond(0.5));
    let masked = surfaces.with_holes(&[3, 1000], holes).watertightness();
    assert_eq!(
        (masked.parts, masked.open_parts, masked.open_edges),
        (1, 1, 0)
    );
}

/// Lights that leave much of the scene out: narrow ones, and ones that end in it.
fn bounded_lights() -> Vec<LightSpace> {
    let from = |eye: DVec3| look_at_mat4(eye, DVec3::ZERO, DVec3::Y);
    let slanted = from(DVec3::new(1.0, 2.0, 0.7));
    let inside = from(DVec3::new(0.1, 0.2, 0.15));
    vec![
        LightSpace::orthographic(slanted, 0.3, 0.5, 0.5, 4.0).unwrap(),
        LightSpace::orthographic(slanted, 1.6, 1.4, 0.5, 2.3).unwrap(),
        LightSpace::orthographic(inside, 0.8, 0.8, -0.3, 0.1).unwrap(),
        LightSpace::perspective(slanted, 0.2, 1.0, 5.0).unwrap(),
        LightSpace::perspective(slanted, 0.7, 1.0, 2.2).unwrap(),
        LightSpace::perspective(inside, 2.0, 0.05, 0.4).unwrap(),
        LightSpace::perspective(inside, 1.0, 0.01, 0.15).unwrap(),
    ]
}

proptest! {
    #![proptest_config(reference::property::cases(100))]

    #[test]
    fn what_a_light_leaves_out_changes_no_bit(
        solids in proptest::collection::vec(solid(), 0..60),
        scale in 1.0_f64..4.0,
        removed in proptest::collection::vec(any::<prop::sample::Index>(), 0..20),
        light in proptest::sample::select([bounded_lights(), lights().to_vec()].concat()),
        rule in proptest::sample::select(vec![Rule::Aligned, Rule::Aligned, Rule::Kampe2015]),
    ) {
        let solids: Vec<Solid> = solids
            .into_iter()
            .map(|solid| Solid { centre: solid.centre * scale, ..solid })
            .collect();
        let mut soup = Soup::of(&solids);
        for triangle in removed {
            if !soup.indices.is_empty() {
                soup.indices.swap_remove(triangle.index(soup.indices.len()));
            }
        }
        let cpu = Cpu::new();
        let positions: &[[f32; 3]] = bytemuck::cast_slice(&soup.positions);
        let surfaces = Surfaces::new(positions, &soup.indices[..]).unwrap();
        let resolution = Resolution::new(128).unwrap();
        let all: Vec<u32> = (0..soup.indices.len() as u32).collect();
        let builder = Builder::new().rule(rule);
        let bake = |mesh: &Mesh| builder.bake(&cpu, mesh).unwrap();
        let without = bake(&Mesh::of_these(&cpu, &surfaces, &all, light, resolution));
        let with = bake(&surfaces.seen_from(light, resolution));
        prop_assert!(with.as_bytes() == without.as_bytes());
    }
}

proptest! {
    #![proptest_config(reference::property::cases(64))]

    #[test]
    fn surfaces_that_are_there_again_change_no_bit(
        solids in proptest::collection::vec(solid(), 1..8),
        removed in proptest::collection::vec(any::<prop::sample::Index>(), 0..20),
        again in proptest::collection::vec(any::<prop::sample::Index>(), 1..40),
        light in proptest::sample::select(lights().to_vec()),
    ) {
        let mut soup = Soup::of(&solids);
        for triangle in removed {
            soup.indices.swap_remove(triangle.index(soup.indices.len()));
            if soup.indices.is_empty() {
                return Ok(());
            }
        }
        let builder = Builder::new();
        let bake = |mesh: &Mesh| builder.bake(&Cpu::new(), mesh).unwrap();
        // A solid of which a triangle is there twice encloses nothing; so do all here.
        let open = |soup: &Soup| {
            let holes = Arc::new(Beyond(f64::INFINITY));
            let positions: &[[f32; 3]] = bytemuck::cast_slice(&soup.positions);
            let all: Vec<u32> = (0..soup.indices.len() as u32).collect();
            let surfaces = Surfaces::new(positions, &soup.indices[..]).unwrap();
            let closed = surfaces.with_holes(&all, holes).closed;
            assert!(closed.iter().all(|closed| !closed));
            let mut surfaces = Surfaces::new(positions, &soup.indices[..]).unwrap();
            surfaces.closed = closed;
            surfaces.seen_from(light, Resolution::new(128).unwrap())
        };
        let once = open(&soup);
        for triangle in again {
            let [a, b, c] = soup.indices[triangle.index(soup.indices.len())];
            soup.indices.extend([[a, b, c], [a, c, b]]);
        }
        let twice = open(&soup);
        prop_assert!(twice.triangles.len() >= once.triangles.len());
        prop_assert!(bake(&twice).as_bytes() == bake(&once).as_bytes());
    }
}

#[test]
fn ten_thousand_surfaces_in_one_place_are_one() {
    let mut soup = Soup::of(&[Solid {
        centre: DVec3::ZERO,
        half: DVec3::splat(0.3),
        turn: DQuat::from_rotation_x(0.4),
    }]);
    soup.indices.truncate(7);
    let once = soup.mesh(64, lights()[0]);
    soup.indices = soup.indices.repeat(10_000);
    let again = soup.mesh(64, lights()[0]);
    assert!(again.triangles == once.triangles);
}

#[test]
fn a_light_leaves_out_what_is_beside_and_behind_its_grid() {
    // Cubes in a row away from a light at the origin, in one that ends among them.
    let row = |step: f64| {
        let solids: Vec<Solid> = (1..=40)
            .map(|i| Solid {
                centre: DVec3::new(0.0, 0.0, -step * f64::from(i)),
                half: DVec3::splat(0.25),
                turn: DQuat::IDENTITY,
            })
            .collect();
        Soup::of(&solids)
    };
    let light = LightSpace::perspective(DMat4::IDENTITY, 1.0, 0.5, 10.0).unwrap();
    let sun = LightSpace::orthographic(DMat4::IDENTITY, 2.0, 2.0, 0.0, 10.0).unwrap();
    for light in [light, sun] {
        let behind = row(1.0).mesh(64, light).triangles.len();
        assert!((12 * 9..=12 * 13).contains(&behind), "{behind}");
        assert_eq!(
            row(-1.0).mesh(64, light).triangles.len(),
            if light == sun { 12 * 40 } else { 0 }
        );
    }
    let away = row(1.0).mesh(
        64,
        LightSpace::perspective(DMat4::from_rotation_y(1.6), 1.0, 0.5, 10.0).unwrap(),
    );
    assert_eq!(away.triangles.len(), 0);
}

#[test]
fn any_number_of_threads_sorts_triangles_alike() {
    // Solids, one of them inside out, and others with a triangle missing; some
    // beside the map, and enough of them for several runs of triangles.
    let mut random = Random::new(7);
    let mut next = || f64::from(random.unit()) - 0.5;
    let solids: Vec<Solid> = (0..3000)
        .map(|_| Solid {
            centre: DVec3::new(next(), next(), next()) * 3.0,
            half: DVec3::new(next(), next(), next()).abs() * 0.1 + 0.001,
            turn: DQuat::from_rotation_x(6.0 * next()),
        })
        .collect();
    let soup = Soup::of(&solids);
    let mut indices = soup.indices.clone();
    (indices[..12].iter_mut()).for_each(|corners| corners.swap(1, 2));
    for triangle in (50..2000).rev().step_by(100) {
        indices.remove(triangle);
    }
    let positions: &[[f32; 3]] = bytemuck::cast_slice(&soup.positions);
    let resolution = Resolution::new(512).unwrap();
    let sorted = |cpu: &Cpu| Surfaces::sorted(cpu, positions.into(), indices[..].into()).unwrap();
    let alone = sorted(&Cpu::single_threaded());
    let watertightness = alone.watertightness();
    assert_eq!(
        (watertightness.open_parts, watertightness.inverted_parts),
        (20, 1)
    );
    assert_eq!(
        (watertightness.parts, watertightness.open_edges),
        (3000, 60)
    );
    let holes = Arc::new(Beyond(0.5));
    let holed = (alone.clone()).with_holes(&[3, 20_000, 30_001], holes);
    for number in [1, 2, 5] {
        let cpu = threads(number);
        let together = sorted(&cpu);
        assert_eq!(together.closed, alone.closed);
        assert_eq!(together.watertightness(), watertightness);
        for light in lights() {
            for surfaces in [&alone, &holed] {
                let [found, expected] = [&cpu, &Cpu::single_threaded()]
                    .map(|cpu| Mesh::of(cpu, surfaces, light, resolution));
                assert!(found.triangles == expected.triangles);
                assert_eq!(found.bins, expected.bins);
                assert_eq!(found.identity(), expected.identity());
            }
        }
    }
}
