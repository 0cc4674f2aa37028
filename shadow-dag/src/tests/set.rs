use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use gpu_backend::Cpu;
use proptest::prelude::*;

use super::mesh::{Soup, lights, solid};
use crate::{
    Builder, CheckpointError, Error, FileError, Form, LightSpace, Resolution, SetBake, SetError,
    ShadowDag, ShadowSet, Surfaces,
};

const SIDE: u32 = 64;

fn surfaces(soup: &Soup) -> Surfaces<'_> {
    Surfaces::new(bytemuck::cast_slice(&soup.positions), &soup.indices[..]).unwrap()
}

fn begin<'a>(soup: &'a Soup, lights: &[Vec<LightSpace>]) -> SetBake<'a> {
    let resolution = Resolution::new(SIDE).unwrap();
    SetBake::new(Builder::new(), surfaces(soup), resolution, lights.to_vec()).unwrap()
}

fn example() -> Soup {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let solids = proptest::collection::vec(solid(), 6);
    Soup::of(&solids.new_tree(&mut runner).unwrap().current())
}

/// Two lights: one grid, and three.
fn two_lights() -> Vec<Vec<LightSpace>> {
    let [a, b, c, d] = lights();
    vec![vec![a], vec![b, c, d]]
}

fn baked() -> ShadowSet {
    let soup = example();
    let mut bake = begin(&soup, &two_lights());
    run(&mut bake).unwrap();
    bake.finish().unwrap()
}

fn run(bake: &mut SetBake<'_>) -> Result<(), Error> {
    let never = AtomicBool::new(false);
    bake.run(&Cpu::new(), &never, Duration::MAX, |_| {}, |_| Ok(()))
}

fn saved(bake: &SetBake<'_>) -> Vec<u8> {
    let mut bytes = Vec::new();
    bake.save(&mut bytes).unwrap();
    bytes
}

proptest! {
    #![proptest_config(reference::property::cases(24))]

    #[test]
    fn the_grids_of_several_lights_are_those_of_each_whatever_the_breaks(
        solids in proptest::collection::vec(solid(), 1..6),
        breaks in proptest::collection::vec((1_usize..200, any::<bool>()), 0..8),
    ) {
        let soup = Soup::of(&solids);
        let never = AtomicBool::new(false);
        let lights = two_lights();
        let mut bake = begin(&soup, &lights);
        for (most, resume) in breaks {
            bake.advance(&Cpu::new(), most, &never, |_| {}).unwrap();
            if resume {
                let (checkpoint, progress) = (saved(&bake), bake.progress());
                bake = begin(&soup, &lights);
                bake.resume(&checkpoint).unwrap();
                prop_assert_eq!(bake.progress(), progress);
            }
        }
        run(&mut bake).unwrap();
        let set = bake.finish().unwrap();
        prop_assert_eq!(set.lights().map(<[_]>::len).collect::<Vec<_>>(), vec![1, 3]);
        for (grid, light) in set.grids().zip(lights.concat()) {
            let alone = Builder::new().bake(&Cpu::new(), &soup.mesh(SIDE, light)).unwrap();
            prop_assert!(grid.as_bytes() == alone.as_bytes());
        }
    }
}

#[test]
fn a_run_saves_when_it_is_stopped_and_goes_on_from_there() {
    let soup = example();
    let whole = baked().to_bytes();
    let tiles = begin(&soup, &two_lights()).progress().tiles;
    // At once, in the second grid, with the last tile.
    for after in [0, tiles / 3, tiles] {
        let stop = AtomicBool::new(after == 0);
        let mut bake = begin(&soup, &two_lights());
        let mut checkpoint = Vec::new();
        let ended = bake.run(
            &Cpu::new(),
            &stop,
            Duration::MAX,
            |progress| stop.store(progress.finished >= after, Ordering::Relaxed),
            |bake| {
                checkpoint = saved(bake);
                Ok(())
            },
        );
        let Err(Error::Cancelled { finished, .. }) = ended else {
            panic!("{ended:?}");
        };
        assert!(finished >= after);
        let mut bake = begin(&soup, &two_lights());
        bake.resume(&checkpoint).unwrap();
        assert_eq!(bake.progress().finished, finished);
        run(&mut bake).unwrap();
        assert!(bake.finish().unwrap().to_bytes() == whole);
    }
}

#[test]
fn a_run_without_a_pause_saves_after_every_part() {
    let soup = example();
    let mut bake = begin(&soup, &two_lights());
    let never = AtomicBool::new(false);
    let (mut last, mut times) = (0, 0);
    let ended = bake.run(
        &Cpu::new(),
        &never,
        Duration::ZERO,
        |_| {},
        |bake| {
            let finished = bake.progress().finished;
            assert!(finished > last);
            (last, times) = (finished, times + 1);
            Ok::<_, Error>(())
        },
    );
    ended.unwrap();
    assert!(times >= 1 && bake.progress().is_complete());
}

#[test]
fn errors_of_saving_end_a_run() {
    let soup = example();
    let mut bake = begin(&soup, &two_lights());
    let stop = AtomicBool::new(true);
    let ended = bake.run(
        &Cpu::new(),
        &stop,
        Duration::MAX,
        |_| {},
        |_| Err(Box::<dyn std::error::Error>::from("full")),
    );
    assert_eq!(ended.unwrap_err().to_string(), "full");
}

#[test]
fn lights_without_grids_are_errors() {
    let soup = example();
    for lights in [vec![], vec![vec![]], vec![vec![lights()[0]], vec![]]] {
        let resolution = Resolution::new(SIDE).unwrap();
        let bake = SetBake::new(Builder::new(), surfaces(&soup), resolution, lights);
        assert!(matches!(bake.unwrap_err(), Error::Length { given: 0, .. }));
    }
    let grid = baked().into_lights().swap_remove(0).swap_remove(0);
    let error = |lights| ShadowSet::new(lights).unwrap_err();
    assert_eq!(error(vec![]), SetError::NoGrid(0));
    assert_eq!(error(vec![vec![grid], vec![]]), SetError::NoGrid(1));
}

#[test]
fn compressed_sets_come_back_packed() {
    let set = baked();
    let packed = set.to_form(Form::Packed).unwrap().to_bytes();
    let compressed = set.compress();
    assert!(compressed.len() < packed.len());
    let read = ShadowSet::read(&compressed).unwrap();
    assert!(read.to_bytes() == packed);
    assert!(ShadowSet::read(&packed).unwrap().to_bytes() == packed);
    let error = ShadowSet::from_bytes(&compressed).unwrap_err();
    let expected = SetError::Grid {
        grid: 0,
        error: FileError::Compressed,
    };
    assert_eq!(error, expected);
    for length in (0..compressed.len()).step_by(7) {
        assert!(ShadowSet::read(&compressed[..length]).is_err(), "{length}");
    }
}

#[test]
fn sets_come_back_from_files() {
    for set in [baked(), baked().to_form(Form::Packed).unwrap()] {
        let file = set.to_bytes();
        let mut written = Vec::new();
        set.write(&mut written).unwrap();
        assert!(written == file);
        let read = ShadowSet::from_bytes(&file).unwrap();
        assert!(read.to_bytes() == file);
        assert_eq!(read.lights().map(<[_]>::len).collect::<Vec<_>>(), [1, 3]);
        for (read, grid) in read.grids().zip(set.grids()) {
            assert!(read.as_bytes() == grid.as_bytes());
        }
    }
}

#[test]
fn files_of_one_grid_and_of_six_in_the_earlier_form_are_sets_of_one_light() {
    let grid = baked().into_lights().swap_remove(0).swap_remove(0);
    let one = ShadowSet::from_bytes(grid.as_bytes()).unwrap();
    assert_eq!(one.lights().map(<[_]>::len).collect::<Vec<_>>(), [1]);
    assert!(one.to_bytes() == grid.as_bytes());

    let length = (grid.as_bytes().len() as u64).to_le_bytes();
    let six = [
        b"CPVSCUBE".to_vec(),
        length.repeat(6),
        grid.as_bytes().repeat(6),
    ]
    .concat();
    let read = ShadowSet::from_bytes(&six).unwrap();
    assert_eq!(read.lights().map(<[_]>::len).collect::<Vec<_>>(), [6]);
    assert!(read.grids().all(|read| read.as_bytes() == grid.as_bytes()));
    for cut in 0..six.len() {
        let error = ShadowSet::from_bytes(&six[..cut]).unwrap_err();
        let expected = if cut < 8 {
            matches!(error, SetError::Magic | SetError::Grid { .. })
        } else {
            matches!(error, SetError::Head(FileError::Truncated { .. }))
        };
        assert!(expected, "{cut}: {error}");
    }
    let longer = [&six[..], b"!"].concat();
    let error = ShadowSet::from_bytes(&longer).unwrap_err();
    assert!(matches!(error, SetError::Head(FileError::TooLong { .. })));
}

#[test]
fn what_is_no_set_is_refused_by_name() {
    let soup = example();
    let mut bake = begin(&soup, &two_lights());
    assert_eq!(
        ShadowSet::from_bytes(&saved(&bake)).unwrap_err(),
        SetError::Unfinished
    );
    let message = ShadowSet::from_bytes(b"anything").unwrap_err().to_string();
    assert!(message.contains("not a file of shadows"), "{message}");

    let file = baked().to_bytes();
    for cut in 0..file.len() {
        assert!(ShadowSet::from_bytes(&file[..cut]).is_err(), "{cut}");
    }
    assert!(ShadowSet::from_bytes(&[&file[..], b"!"].concat()).is_err());
    let head = 24 + 2 * 4 + 4 * 8;
    for at in 0..head + 200 {
        for value in [0, 1, 0x7f, 0xff] {
            let mut bytes = file.clone();
            bytes[at] = value;
            let sound = ShadowSet::from_bytes(&bytes).is_ok();
            assert_eq!(sound, bytes == file, "{at}");
        }
    }

    // Files are no checkpoints either, nor are those of one grid.
    assert_eq!(bake.resume(&file), Err(CheckpointError::Magic));
    let mesh = soup.mesh(SIDE, lights()[0]);
    let mut single = Vec::new();
    crate::Bake::of_mesh(Builder::new(), &mesh)
        .save(&mut single)
        .unwrap();
    assert_eq!(bake.resume(&single), Err(CheckpointError::Magic));
}

#[test]
fn checkpoints_of_other_sets_are_refused() {
    let soup = example();
    let never = AtomicBool::new(false);
    let mut bake = begin(&soup, &two_lights());
    for _ in 0..3 {
        bake.advance(&Cpu::new(), usize::MAX, &never, |_| {})
            .unwrap();
    }
    assert_eq!(bake.grid(), (2, 4));
    let checkpoint = saved(&bake);
    let [a, b, c, d] = lights();
    let refused = |lights: &[Vec<LightSpace>], soup: &Soup| {
        let mut other = begin(soup, lights);
        let error = other.resume(&checkpoint).unwrap_err();
        assert_eq!(other.progress().finished, 0, "{error}");
        error
    };
    let fewer = refused(&[vec![a, b]], &soup);
    assert_eq!(fewer, CheckpointError::Grids { found: 2, grids: 2 });
    let swapped = refused(&[vec![a, c, b, d]], &soup);
    assert_eq!(swapped, CheckpointError::OtherGrid { grid: 1 });
    let next = refused(&[vec![a, b, d]], &soup);
    assert!(matches!(next, CheckpointError::Foreign { .. }), "{next}");
    let scene = refused(&two_lights(), &Soup::of(&[]));
    assert!(matches!(scene, CheckpointError::Foreign { .. }), "{scene}");
    // How the grids are shared out among the lights does not matter.
    begin(&soup, &[vec![a, b], vec![c, d]])
        .resume(&checkpoint)
        .unwrap();

    for cut in (0..checkpoint.len()).step_by(11) {
        let error = begin(&soup, &two_lights()).resume(&checkpoint[..cut]);
        assert!(error.is_err(), "{cut}");
    }
    for at in 0..24 + 200 {
        let mut bytes = checkpoint.clone();
        bytes[at] ^= 0x41;
        let error = begin(&soup, &two_lights()).resume(&bytes);
        assert!(error.is_err(), "{at}");
    }
}

#[test]
fn grids_in_one_buffer_answer_as_they_do_alone() {
    let set = baked();
    let grids: Vec<&ShadowDag> = set.grids().collect();
    let owned: Vec<ShadowDag> = grids.iter().map(|grid| (*grid).clone()).collect();
    let resident = ShadowDag::upload_all(&owned, &Cpu::new()).unwrap();
    for (alone, together) in grids.iter().zip(&resident) {
        assert!(alone.as_bytes() == together.as_bytes());
        assert_eq!(together.buffer_bytes(), resident[0].buffer_bytes());
        for i in 0..2000 {
            let voxel = glam::IVec3::new(i % 61, i * 7 % 64, i * 13 % 59);
            assert_eq!(alone.is_lit(voxel), together.is_lit(voxel));
        }
    }
}
