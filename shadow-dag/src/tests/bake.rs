use std::sync::atomic::{AtomicBool, Ordering};

use gpu_backend::Cpu;
use proptest::prelude::*;
use reference::random::Random;

use super::build::Hills;
use super::mesh::{Soup, lights, solid};
use crate::{
    Bake, Builder, CheckpointError, DepthSource, Error, LightSpace, Mesh, Progress, Resolution,
    Rule,
};

pub(crate) fn threads(number: usize) -> Cpu {
    #[cfg(feature = "rayon")]
    if number > 1 {
        return Cpu::with_threads(number).unwrap();
    }
    assert!(number >= 1);
    Cpu::single_threaded()
}

fn saved(bake: &Bake<'_>) -> Vec<u8> {
    let mut bytes = Vec::new();
    bake.save(&mut bytes).unwrap();
    bytes
}

/// Goes on until `tiles` tiles have been finished in this call.
fn stop_after(bake: &mut Bake<'_>, cpu: &Cpu, tiles: usize) -> Result<Progress, Error> {
    let before = bake.progress().finished;
    let stop = AtomicBool::new(tiles == 0);
    bake.advance(cpu, usize::MAX, &stop, |progress| {
        stop.store(progress.finished >= before + tiles, Ordering::Relaxed);
    })
}

fn go_on(bake: &mut Bake<'_>) {
    let never = AtomicBool::new(false);
    let end = bake
        .advance(&Cpu::new(), usize::MAX, &never, |_| {})
        .unwrap();
    assert!(end.is_complete());
}

/// A few solids, and the whole bake of them.
fn example(light: LightSpace) -> Mesh {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let solids = proptest::collection::vec(solid(), 12);
    let solids = solids.new_tree(&mut runner).unwrap().current();
    Soup::of(&solids).mesh(512, light)
}

proptest! {
    #![proptest_config(reference::property::cases(48))]

    #[test]
    fn breaks_leave_no_trace_in_the_result(
        solids in proptest::collection::vec(solid(), 1..8),
        light in proptest::sample::select(lights().to_vec()),
        rule in proptest::sample::select(vec![Rule::Aligned, Rule::Aligned, Rule::Kampe2015]),
        breaks in proptest::collection::vec((0_usize..3000, 1_usize..4, any::<bool>()), 0..4),
    ) {
        let mesh = Soup::of(&solids).mesh(256, light);
        let builder = Builder::new().rule(rule);
        let whole = builder.bake(&Cpu::single_threaded(), &mesh).unwrap();
        let mut bake = Bake::of_mesh(builder, &mesh);
        for (tiles, number, resume) in breaks {
            let before = bake.progress();
            match stop_after(&mut bake, &threads(number), tiles) {
                Ok(progress) => prop_assert!(progress.is_complete()),
                Err(Error::Cancelled { finished, tiles: all }) => {
                    prop_assert!(finished >= (before.finished + tiles).min(all));
                    prop_assert_eq!(bake.progress(), Progress { finished, tiles: all });
                }
                Err(error) => prop_assert!(false, "{}", error),
            }
            if resume {
                let checkpoint = saved(&bake);
                let progress = bake.progress();
                bake = Bake::of_mesh(builder, &mesh);
                bake.resume(&checkpoint).unwrap();
                prop_assert_eq!(bake.progress(), progress);
            }
        }
        go_on(&mut bake);
        prop_assert!(bake.finish().unwrap().as_bytes() == whole.as_bytes());
    }
}

#[test]
fn tiles_are_counted_one_by_one_and_made_as_many_as_asked_for() {
    let mesh = example(lights()[0]);
    let mut bake = Bake::of_mesh(Builder::new(), &mesh);
    assert_eq!(
        bake.progress(),
        Progress {
            finished: 0,
            tiles: 4096
        }
    );
    let never = AtomicBool::new(false);
    let mut next = 1;
    for most in [0, 1, 100, usize::MAX] {
        let progress = bake
            .advance(&Cpu::new(), most, &never, |progress| {
                assert_eq!(progress.finished, next);
                next += 1;
            })
            .unwrap();
        assert_eq!(progress, bake.progress());
        assert_eq!(progress.finished, next - 1);
    }
    assert_eq!(next, 4097);
}

#[test]
fn maps_are_resumed_by_region() {
    let hills = Hills(Resolution::new(4096).unwrap());
    let builder = Builder::new();
    let mut bake = Bake::of_depths(builder, &hills, 1);
    stop_after(&mut bake, &threads(2), 3).unwrap_err();
    let checkpoint = saved(&bake);
    let mut resumed = Bake::of_depths(builder, &hills, 1);
    resumed.resume(&checkpoint).unwrap();
    assert_eq!(resumed.progress(), bake.progress());
    go_on(&mut resumed);
    let whole = builder.build(&Cpu::new(), &hills).unwrap();
    assert!(resumed.finish().unwrap().as_bytes() == whole.as_bytes());
    let other = Bake::of_depths(builder, &hills, 2).resume(&checkpoint);
    assert!(matches!(other, Err(CheckpointError::Foreign { .. })));
}

#[test]
fn what_is_not_finished_is_no_result() {
    let mesh = example(lights()[1]);
    let mut bake = Bake::of_mesh(Builder::new(), &mesh);
    let error = stop_after(&mut bake, &Cpu::new(), 100).unwrap_err();
    assert!(error.to_string().ends_with("of 4096 tiles"), "{error}");
    let Error::Cancelled { finished, tiles } = bake.finish().unwrap_err() else {
        panic!("it was not finished");
    };
    assert!((100..4096).contains(&finished) && tiles == 4096);
}

/// Stops on its third tile while it is in the middle of it.
#[test]
fn a_stop_from_elsewhere_ends_a_tile_early() {
    struct Slow<'a>(Hills, &'a AtomicBool);
    impl DepthSource for Slow<'_> {
        fn resolution(&self) -> Resolution {
            self.0.resolution()
        }
        fn read(
            &self,
            tile: crate::TileRect,
            enter: &mut [u32],
            exit: &mut [u32],
        ) -> Result<crate::Exits, Error> {
            self.1.store(tile.x > 0, Ordering::Relaxed);
            self.0.read(tile, enter, exit)
        }
    }
    let stop = AtomicBool::new(false);
    let slow = Slow(Hills(Resolution::new(2048).unwrap()), &stop);
    let mut bake = Bake::of_depths(Builder::new(), &slow, 0);
    let error = bake.advance(&Cpu::single_threaded(), usize::MAX, &stop, |_| {});
    assert!(matches!(
        error,
        Err(Error::Cancelled {
            finished: 1,
            tiles: 4
        })
    ));
    let mut rest = Bake::of_depths(Builder::new(), &slow.0, 0);
    rest.resume(&saved(&bake)).unwrap();
    go_on(&mut rest);
    let whole = Builder::new().build(&Cpu::new(), &slow.0).unwrap();
    assert!(rest.finish().unwrap().as_bytes() == whole.as_bytes());
}

#[test]
fn a_source_that_fails_once_can_be_asked_again() {
    struct Flaky(Hills, AtomicBool);
    impl DepthSource for Flaky {
        fn resolution(&self) -> Resolution {
            self.0.resolution()
        }
        fn read(
            &self,
            tile: crate::TileRect,
            enter: &mut [u32],
            exit: &mut [u32],
        ) -> Result<crate::Exits, Error> {
            if tile.x > 0 && tile.y > 0 && self.1.swap(false, Ordering::Relaxed) {
                return Err(Error::Source {
                    x: tile.x,
                    y: tile.y,
                    source: "offline".into(),
                });
            }
            self.0.read(tile, enter, exit)
        }
    }
    let flaky = Flaky(Hills(Resolution::new(2048).unwrap()), AtomicBool::new(true));
    let mut bake = Bake::of_depths(Builder::new(), &flaky, 0);
    let never = AtomicBool::new(false);
    let error = bake
        .advance(&Cpu::new(), usize::MAX, &never, |_| {})
        .unwrap_err();
    assert!(
        matches!(
            error,
            Error::Source {
                x: 1024,
                y: 1024,
                ..
            }
        ),
        "{error}"
    );
    assert_eq!(bake.progress().finished, 3);
    go_on(&mut bake);
    let whole = Builder::new().build(&Cpu::new(), &flaky.0).unwrap();
    assert!(bake.finish().unwrap().as_bytes() == whole.as_bytes());
}

#[test]
fn checkpoints_of_other_bakes_are_refused() {
    let mesh = example(lights()[0]);
    let mut bake = Bake::of_mesh(Builder::new(), &mesh);
    stop_after(&mut bake, &Cpu::new(), 500).unwrap_err();
    let checkpoint = saved(&bake);
    let finer = mesh.clone().with_resolution(Resolution::new(1024).unwrap());
    let lit = example(lights()[1]);
    let moved = {
        let solids = Soup::of(&[]);
        solids.mesh(512, lights()[0])
    };
    let rule = Builder::new().rule(Rule::Sintorn2014);
    for (name, mut other) in [
        ("resolution", Bake::of_mesh(Builder::new(), &finer)),
        ("light", Bake::of_mesh(Builder::new(), &lit)),
        ("triangles", Bake::of_mesh(Builder::new(), &moved)),
        ("rule", Bake::of_mesh(rule, &mesh)),
    ] {
        let error = other.resume(&checkpoint).unwrap_err();
        assert!(
            matches!(error, CheckpointError::Foreign { .. }),
            "{name}: {error}"
        );
        assert_eq!(other.progress().finished, 0, "{name}");
    }
    // How nodes are found does not matter to what they are.
    let mut other = Bake::of_mesh(Builder::new().culling(false), &mesh);
    other.resume(&checkpoint).unwrap();
    go_on(&mut other);
    go_on(&mut bake);
    assert!(other.finish().unwrap().as_bytes() == bake.finish().unwrap().as_bytes());
}

/// Puts the right checksum at the end.
fn seal(checkpoint: &mut [u8]) {
    let end = checkpoint.len().saturating_sub(4);
    let sum = crc32fast::hash(&checkpoint[..end]);
    checkpoint[end..].copy_from_slice(&sum.to_le_bytes());
}

#[test]
fn damage_is_found_out_and_forgery_does_no_harm() {
    let mesh = example(lights()[2]).with_resolution(Resolution::new(256).unwrap());
    let fresh = || Bake::of_mesh(Builder::new(), &mesh);
    let mut bake = fresh();
    stop_after(&mut bake, &threads(2), 700).unwrap_err();
    let checkpoint = saved(&bake);
    for length in (0..checkpoint.len()).step_by(7) {
        assert!(fresh().resume(&checkpoint[..length]).is_err(), "{length}");
    }
    let mut longer = checkpoint.clone();
    longer.push(0);
    assert!(fresh().resume(&longer).is_err());
    seal(&mut longer);
    assert!(fresh().resume(&longer).is_err());

    let mut random = Random::new(1);
    let mut next = || (random.bits() >> 40) as u32;
    let mut accepted = 0;
    for round in 0..4000 {
        let mut bytes = checkpoint.clone();
        // Headers are as likely as all the rest.
        let most = [60, bytes.len(), 20_000.min(bytes.len())][round % 3];
        let at = next() as usize % most;
        let old = bytes[at];
        bytes[at] = [next() as u8, 0, 0xff, old ^ 1][round / 3 % 4];
        if bytes[at] == old {
            continue;
        }
        assert!(fresh().resume(&bytes).is_err(), "byte {at}");
        seal(&mut bytes);
        let mut forged = fresh();
        if forged.resume(&bytes).is_ok() {
            accepted += 1;
            go_on(&mut forged);
            let dag = forged.finish().unwrap();
            // Whatever it says, it is one.
            crate::ShadowDag::from_bytes(dag.into_bytes()).unwrap();
        }
    }
    assert!(accepted > 10, "{accepted}: masks may be anything");
}
