//! Open surfaces in a plane, whose columns are kept and recalled.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::{DMat4, DQuat, DVec3};
use gpu_backend::Cpu;
use proptest::prelude::*;

use super::mesh::{Soup, lights, solid};
use crate::footprint::{Content, Footprints};
use crate::mesh::{Mesh, Scratch};
use crate::patches::Patch;
use crate::rule::Tile;
use crate::tiles::{Tiles, Watch};
use crate::{Bake, Builder, DepthSource, LightSpace, Resolution};

/// A sun over everything within 0.5 of the origin, whose rays come from `from`.
fn sun(from: DVec3) -> LightSpace {
    let turn = DQuat::from_rotation_arc(DVec3::Z, from.normalize());
    let view = DMat4::from_rotation_translation(turn, from.normalize()).inverse();
    LightSpace::orthographic(view, 1.6, 1.5, 0.1, 1.9).unwrap()
}

/// A parallelogram of two triangles around the origin, which encloses nothing.
fn floor(soup: &mut Soup, [u, v]: [DVec3; 2]) {
    let first = soup.positions.len() as u32;
    for corner in [-u - v, u - v, u + v, v - u] {
        soup.positions.push(corner.as_vec3());
    }
    soup.indices.push([first, first + 1, first + 2]);
    soup.indices.push([first, first + 2, first + 3]);
}

fn level_floor() -> Soup {
    let mut soup = Soup::default();
    floor(&mut soup, [DVec3::X * 0.5, DVec3::Y * 0.5]);
    soup
}

proptest! {
    #![proptest_config(reference::property::cases(24))]

    // Open surfaces leave nothing to choose: whoever builds their shadows gets
    // the same, and maps are read without any patches.
    #[test]
    fn planes_make_the_nodes_of_their_maps(
        from in (-1.0_f64..1.0, -1.0_f64..1.0, 0.05_f64..1.0),
        axes in proptest::array::uniform2((-0.5_f64..0.5, -0.5_f64..0.5, -0.5_f64..0.5)),
        second in proptest::option::of(proptest::array::uniform2(
            (-0.2_f64..0.2, -0.2_f64..0.2, -0.2_f64..0.2)
        )),
        side in proptest::sample::select(&[256_u32, 1024][..]),
    ) {
        let mut soup = Soup::default();
        floor(&mut soup, axes.map(DVec3::from));
        if let Some(axes) = second {
            floor(&mut soup, axes.map(DVec3::from));
        }
        let mesh = soup.mesh(side, sun(from.into()));
        let cpu = Cpu::new();
        let expected = Builder::new().build(&cpu, &mesh).unwrap();
        prop_assert!(Builder::new().bake(&cpu, &mesh).unwrap().as_bytes() == expected.as_bytes());
    }
}

#[test]
fn planes_whose_slopes_are_fractions_make_the_nodes_of_their_maps() {
    let cpu = Cpu::new();
    // Straight down, by a half, by one, nearly level, and grazing.
    for x in [0.0, 0.5, 1.0, 1e-4, 1e-9, 8.0] {
        for light in [sun(DVec3::new(x, 0.0, 1.0)), sun(DVec3::new(x, -x, 1.0))] {
            let mesh = level_floor().mesh(2048, light);
            let baked = Builder::new().bake(&cpu, &mesh).unwrap();
            let built = Builder::new().build(&cpu, &mesh).unwrap();
            assert!(baked.as_bytes() == built.as_bytes(), "{x}");
        }
    }
    // Through lights at a point too.
    for light in &lights()[2..] {
        let mesh = level_floor().mesh(1024, *light);
        let baked = Builder::new().bake(&cpu, &mesh).unwrap();
        let built = Builder::new().build(&cpu, &mesh).unwrap();
        assert!(baked.as_bytes() == built.as_bytes());
    }
}

#[test]
fn floors_under_solids_are_the_same_on_any_number_of_threads_and_with_breaks() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let solids = proptest::collection::vec(solid(), 5);
    let mut soup = Soup::of(&solids.new_tree(&mut runner).unwrap().current());
    floor(&mut soup, [DVec3::X * 0.5, DVec3::Y * 0.5]);
    let mesh = soup.mesh(2048, sun(DVec3::new(0.3, 0.2, 0.7)));
    let single = Builder::new().bake(&Cpu::single_threaded(), &mesh).unwrap();
    #[cfg(feature = "rayon")]
    for threads in [2, 5] {
        let many = Builder::new().bake(&Cpu::with_threads(threads).unwrap(), &mesh);
        assert!(many.unwrap().as_bytes() == single.as_bytes());
    }
    let mut bake = Bake::of_mesh(Builder::new(), &mesh);
    let stop = AtomicBool::new(false);
    while !bake.progress().is_complete() {
        let before = bake.progress().finished;
        // Stopped in the middle of tiles, and resumed without what was kept.
        let _ = bake.advance(&Cpu::new(), 300, &stop, |progress| {
            stop.store(progress.finished >= before + 200, Ordering::Relaxed);
        });
        stop.store(false, Ordering::Relaxed);
        let mut checkpoint = Vec::new();
        bake.save(&mut checkpoint).unwrap();
        if before.is_multiple_of(3) {
            bake = Bake::of_mesh(Builder::new(), &mesh);
            bake.resume(&checkpoint).unwrap();
        }
    }
    assert!(bake.finish().unwrap().as_bytes() == single.as_bytes());
}

/// Counts footprints that are looked at.
struct Counted<'a>(Scratch<'a>, &'a AtomicUsize);

impl<'a> Footprints for Counted<'a> {
    type Part = <Scratch<'a> as Footprints>::Part;

    fn content(&mut self, level: usize, part: Self::Part, tile: &mut Tile) -> Content<Self::Part> {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.content(level, part, tile)
    }

    fn leave(&mut self, part: Self::Part) {
        self.0.leave(part);
    }

    fn patch(&self, level: usize, part: Self::Part) -> Option<Patch> {
        self.0.patch(level, part)
    }
}

/// How many footprints a bake on one thread looks at.
fn looks(mesh: &Mesh) -> usize {
    let count = AtomicUsize::new(0);
    let plan = Builder::new().plan_of_mesh(mesh.resolution());
    let stop = AtomicBool::new(false);
    let watch = Watch {
        stop: &stop,
        pause: &|| false,
        observe: &mut |_| {},
    };
    let scratch = || Counted(Scratch::new(mesh, true), &count);
    Tiles::new(plan)
        .advance(
            &Cpu::single_threaded(),
            usize::MAX,
            watch,
            scratch,
            |scratch, x, y| Ok(scratch.0.start(plan.tile(x, y))),
        )
        .unwrap();
    count.into_inner()
}

#[test]
fn few_footprints_of_a_floor_are_looked_at() {
    for from in [
        DVec3::new(0.3, 0.5, 0.8),
        DVec3::new(-0.9, 0.1, 0.3),
        DVec3::Z,
    ] {
        let mut mesh = level_floor().mesh(1024, sun(from));
        let mut counts = Vec::new();
        for log2 in 10..=13 {
            mesh = mesh.with_resolution(Resolution::new(1 << log2).unwrap());
            counts.push(looks(&mesh) as f64);
        }
        println!("{from}: {counts:?}");
        for pair in counts.windows(2) {
            assert!(pair[1] <= 2.6 * pair[0], "{from}: {counts:?}");
        }
        // Three doublings.
        assert!(
            counts[3] <= 2.3_f64.powi(3) * counts[0],
            "{from}: {counts:?}"
        );
    }
}
