use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use gpu_backend::Cpu;
use proptest::prelude::*;

use super::bake::threads;
use super::mesh::{Soup, lights, solid};
use crate::{
    Builder, CheckpointError, Error, FileError, Form, LightEntry, LightGrids, LightSpace,
    MergeError, Resolution, SetBake, SetError, ShadowDag, ShadowSet, Share, Surfaces,
};

const SIDE: u32 = 64;

/// Grids of [`SIDE`] voxels.
fn grids(spaces: &[LightSpace]) -> LightGrids {
    LightGrids::new(spaces.to_vec(), Resolution::new(SIDE).unwrap())
}

fn surfaces(soup: &Soup) -> Surfaces<'_> {
    Surfaces::new(bytemuck::cast_slice(&soup.positions), &soup.indices[..]).unwrap()
}

fn begin<'a>(soup: &'a Soup, lights: &[LightGrids]) -> SetBake<'a> {
    SetBake::new(Builder::new(), surfaces(soup), lights.to_vec()).unwrap()
}

fn example() -> Soup {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let solids = proptest::collection::vec(solid(), 6);
    Soup::of(&solids.new_tree(&mut runner).unwrap().current())
}

/// Two lights: one grid, and three.
fn two_lights() -> Vec<LightGrids> {
    let [a, b, c, d] = lights();
    vec![grids(&[a]), grids(&[b, c, d])]
}

/// The same with resolutions and a bias of their own.
fn unlike_lights() -> Vec<LightGrids> {
    let mut lights = two_lights();
    lights[1].resolution = Resolution::new(2 * SIDE).unwrap();
    lights[0].bias = 2.5;
    lights
}

fn baked() -> ShadowSet {
    whole(&example(), &two_lights())
}

fn begin_example() -> SetBake<'static> {
    let Soup { positions, indices } = example();
    let positions: Vec<[f32; 3]> = positions.iter().map(|at| at.to_array()).collect();
    let surfaces = Surfaces::new(positions, indices).unwrap();
    SetBake::new(Builder::new(), surfaces, two_lights()).unwrap()
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

/// All of it at once.
fn whole(soup: &Soup, lights: &[LightGrids]) -> ShadowSet {
    let mut bake = begin(soup, lights);
    run(&mut bake).unwrap();
    bake.finish().unwrap()
}

/// What is written of a complete part.
fn part(soup: &Soup, lights: &[LightGrids], share: Share) -> Vec<u8> {
    let mut bake = begin(soup, lights).share(share);
    run(&mut bake).unwrap();
    saved(&bake)
}

proptest! {
    #![proptest_config(reference::property::cases(24))]

    #[test]
    fn the_grids_of_several_lights_are_those_of_each_whatever_the_breaks(
        solids in proptest::collection::vec(solid(), 1..6),
        breaks in proptest::collection::vec((1_usize..400, any::<bool>(), 1_usize..4), 0..8),
    ) {
        let soup = Soup::of(&solids);
        let never = AtomicBool::new(false);
        let lights = unlike_lights();
        let mut bake = begin(&soup, &lights);
        for (most, resume, number) in breaks {
            let before = bake.progress();
            let after = bake.advance(&threads(number), most, &never, |_| {}).unwrap();
            prop_assert_eq!(after.finished, (before.finished + most).min(before.tiles));
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
        prop_assert_eq!([0, 1, 2].map(|light| set.bias(light)), [2.5, 1.0, 1.0]);
        for (own, light) in set.lights().zip(&lights) {
            for (grid, space) in own.iter().zip(&light.spaces) {
                let mesh = soup.mesh(light.resolution.side(), *space);
                let alone = Builder::new().bake(&Cpu::new(), &mesh).unwrap();
                prop_assert!(grid.as_bytes() == alone.as_bytes());
            }
        }
    }

    #[test]
    fn parts_in_any_order_make_the_bytes_of_the_whole(
        solids in proptest::collection::vec(solid(), 1..6),
        parts in 1_u32..9,
        turn in 0_usize..8,
        form in proptest::sample::select(vec![Form::Plain, Form::Packed]),
    ) {
        let soup = Soup::of(&solids);
        let lights = unlike_lights();
        let shares = (1..=parts).map(|part| Share::new(part, parts).unwrap());
        let mut parts: Vec<_> = shares.map(|share| part(&soup, &lights, share)).collect();
        let turn = turn % parts.len();
        parts.rotate_left(turn);
        let merged = ShadowSet::merge(&Cpu::new(), &parts, form).unwrap();
        let whole = whole(&soup, &lights).to_form(form).unwrap();
        prop_assert!(merged.to_bytes() == whole.to_bytes());
    }
}

#[test]
fn parts_that_make_no_whole_are_refused_by_name() {
    let soup = example();
    let lights = two_lights();
    let share = |part, parts| Share::new(part, parts).unwrap();
    let of = |part_, parts| part(&soup, &lights, share(part_, parts));
    let [a, b, c] = [1, 2, 3].map(|number| of(number, 3));
    let merge = |parts: &[&Vec<u8>]| {
        ShadowSet::merge(&Cpu::new(), parts, Form::Plain).map(|set| set.to_bytes())
    };
    assert!(merge(&[&a, &b, &c]).unwrap() == baked().to_bytes());
    // A checkpoint of all of it is its only part.
    let mut all = begin(&soup, &lights);
    run(&mut all).unwrap();
    assert!(merge(&[&saved(&all)]).unwrap() == baked().to_bytes());

    let error = |parts: &[&Vec<u8>]| merge(parts).unwrap_err();
    assert!(matches!(error(&[]), MergeError::Empty));
    let missing = error(&[&c, &a]);
    assert_eq!(missing.to_string(), "1 of 3 parts missing: 2");
    assert!(matches!(missing, MergeError::Missing { missing: 1, .. }));
    let many = error(&[&of(7, 1_000_000)]).to_string();
    assert_eq!(
        many,
        "999999 of 1000000 parts missing: 1, 2, 3, 4, 5, 6, 8, 9, 10, 11, 12, 13, …"
    );
    for parts in [[&a, &b, &a], [&b, &a, &a]] {
        let doubled = error(&parts);
        assert!(
            matches!(doubled, MergeError::Doubled { second: 2, share, .. } if share.part() == 1),
            "{doubled}"
        );
    }
    let other_scene = part(&Soup::of(&[]), &lights, share(2, 3));
    let mut other_bias = two_lights();
    other_bias[0].bias = 2.0;
    let other_bias = part(&soup, &other_bias, share(2, 3));
    for other in [&of(2, 4), &other_scene, &other_bias] {
        let foreign = error(&[&a, other, &c]);
        assert!(
            matches!(foreign, MergeError::Foreign { given: 1, .. }),
            "{foreign}"
        );
    }
    let mut half = begin(&soup, &lights).share(share(2, 3));
    let tiles = half.progress().tiles;
    assert_eq!(tiles, 4 * 64 / 3);
    let never = AtomicBool::new(false);
    half.advance(&Cpu::new(), tiles / 2, &never, |_| {})
        .unwrap();
    let unfinished = error(&[&a, &saved(&half), &c]);
    assert!(
        matches!(unfinished, MergeError::Unfinished { finished, .. } if finished == tiles / 2),
        "{unfinished}"
    );
    // It is no whole by itself, either.
    run(&mut half).unwrap();
    let error = half.finish().unwrap_err();
    assert!(
        matches!(error, Error::Cancelled { tiles: 256, .. }),
        "{error}"
    );

    // Checkpoints are of their own part.
    let mut second = begin(&soup, &lights).share(share(2, 3));
    let refused = second.resume(&a).unwrap_err();
    assert!(
        matches!(refused, CheckpointError::OtherPart { .. }),
        "{refused}"
    );
    second.resume(&b).unwrap();
    assert!(second.progress().is_complete() && saved(&second) == b);
    assert_eq!(ShadowSet::from_bytes(&b).unwrap_err(), SetError::Unfinished);

    // Damage is found, wherever it is.
    for at in (0..b.len()).step_by(b.len() / 500 + 1).chain(0..900) {
        let mut bytes = b.clone();
        bytes[at] ^= 0x41;
        assert!(merge(&[&a, &bytes, &c]).is_err(), "{at}");
    }
    for cut in (0..b.len()).step_by(b.len() / 300 + 1) {
        let cut = b[..cut].to_vec();
        assert!(merge(&[&a, &cut, &c]).is_err());
    }
}

#[test]
fn heads_of_checkpoints_promise_no_more_than_there_is() {
    // Sound checksums around numbers that make no sense.
    let bytes = part(&example(), &two_lights(), Share::default());
    let head = 40 + 2 * 12 + 4 * 160;
    for at in 16..head {
        for value in [0, 1, 0x7f, 0xff] {
            let mut changed = bytes.clone();
            changed[at] = value;
            let sum = crc32fast::hash(&changed[16..head]);
            changed[12..16].copy_from_slice(&sum.to_le_bytes());
            // Either refused or of another bake.
            let mut bake = begin_example();
            let refused = bake.resume(&changed);
            assert_eq!(refused.is_ok(), changed == bytes, "{at}: {value}");
            assert!(refused.is_ok() || bake.progress().finished == 0);
            let _ = ShadowSet::merge(&Cpu::new(), &[changed], Form::Plain);
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
    let (one, none) = (grids(&[lights()[0]]), grids(&[]));
    for lights in [vec![], vec![none.clone()], vec![one.clone(), none]] {
        let bake = SetBake::new(Builder::new(), surfaces(&soup), lights);
        assert!(matches!(bake.unwrap_err(), Error::Length { given: 0, .. }));
    }
    for bias in [-1.0, f32::NAN, f32::INFINITY] {
        let lights = vec![LightGrids {
            bias,
            ..one.clone()
        }];
        let bake = SetBake::new(Builder::new(), surfaces(&soup), lights);
        assert!(matches!(bake.unwrap_err(), Error::BadValue { .. }));
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
    let unlike = whole(&example(), &unlike_lights());
    for set in [baked(), baked().to_form(Form::Packed).unwrap(), unlike] {
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
        // The directory alone tells where the grids of a light are.
        let entries = LightEntry::directory(&file[..24 + 2 * 32 + 4 * 8])
            .unwrap()
            .unwrap();
        let mut end = 24 + 2 * 32 + 4 * 8;
        for (light, (entry, grids)) in entries.iter().zip(set.lights()).enumerate() {
            assert_eq!((entry.grids, entry.bias), (grids.len(), set.bias(light)));
            assert_eq!(read.bias(light), entry.bias);
            assert_eq!(
                (entry.resolution, entry.bytes.start),
                (grids[0].resolution(), end)
            );
            let own = &file[entry.bytes.start as usize..entry.bytes.end as usize];
            let expected: Vec<&[u8]> = grids.iter().map(ShadowDag::as_bytes).collect();
            assert!(own == expected.concat());
            end = entry.bytes.end;
        }
        assert_eq!(end, file.len() as u64);
    }
    // A light of one grid with a bias of its own takes a directory.
    let mut one = two_lights();
    (one[0].bias, one[1].spaces) = (0.0, vec![]);
    one.truncate(1);
    let file = whole(&example(), &one).to_bytes();
    assert_eq!(ShadowSet::from_bytes(&file).unwrap().bias(0), 0.0);
}

/// The file of a set in version 1.
fn counted(set: &ShadowSet) -> Vec<u8> {
    let mut checked = (set.lights().len() as u32).to_le_bytes().to_vec();
    checked.extend([0; 4]);
    let counts = set.lights().map(|grids| grids.len() as u32);
    checked.extend(counts.flat_map(u32::to_le_bytes));
    let lengths = set.grids().map(|grid| grid.as_bytes().len() as u64);
    checked.extend(lengths.flat_map(u64::to_le_bytes));
    let mut file = b"CPVSSET\0".to_vec();
    file.extend(1_u32.to_le_bytes());
    file.extend(crc32fast::hash(&checked).to_le_bytes());
    file.extend(checked);
    set.grids().for_each(|grid| file.extend(grid.as_bytes()));
    file
}

#[test]
fn files_of_version_1_are_read_and_bad_ones_refused() {
    let file = counted(&baked());
    let read = ShadowSet::from_bytes(&file).unwrap();
    assert!(read.to_bytes() == baked().to_bytes());
    assert_eq!(read.bias(1), 1.0);
    assert_eq!(LightEntry::directory(&file), Ok(None));
    refuses_damage(&file, 24 + 2 * 4 + 4 * 8);
}

/// What is cut off, longer or changed is refused, whatever was changed.
fn refuses_damage(file: &[u8], head: usize) {
    for cut in 0..file.len() {
        assert!(ShadowSet::from_bytes(&file[..cut]).is_err(), "{cut}");
    }
    assert!(ShadowSet::from_bytes(&[file, b"!"].concat()).is_err());
    for at in 0..head + 200 {
        for value in [0, 1, 0x7f, 0xff] {
            let mut bytes = file.to_vec();
            bytes[at] = value;
            let sound = ShadowSet::from_bytes(&bytes).is_ok();
            assert_eq!(sound, bytes == file, "{at}");
            // With a sound checksum around it.
            let sum = crc32fast::hash(&bytes[16..head]);
            bytes[12..16].copy_from_slice(&sum.to_le_bytes());
            let _ = ShadowSet::from_bytes(&bytes);
            let _ = LightEntry::directory(&bytes);
        }
    }
}

#[test]
fn directories_that_lie_are_refused() {
    let file = baked().to_bytes();
    let head = 24 + 2 * 32 + 4 * 8;
    for (at, value) in [
        // The number of all grids; of the first light its first grid, resolution, bias,
        // begin and end.
        (20, 5_u32),
        (24, 1),
        (32, 5),
        (32, 77),
        (36, f32::NAN.to_bits()),
        (36, (-1.0_f32).to_bits()),
        (40, 1),
        (48, 1),
    ] {
        let mut bytes = file.clone();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        let sum = crc32fast::hash(&bytes[16..head]);
        bytes[12..16].copy_from_slice(&sum.to_le_bytes());
        assert!(ShadowSet::from_bytes(&bytes).is_err(), "{at}: {value}");
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
fn a_set_is_no_single_grid_and_says_how_to_read_it() {
    let file = baked().to_bytes();
    let error = ShadowDag::from_bytes(&file[..]).unwrap_err();
    assert_eq!(error, FileError::Set { lights: 2 });
    assert_eq!(ShadowDag::read(&file).unwrap_err(), error);
    let message = error.to_string();
    assert!(message.contains("2 light(s)") && message.contains("ShadowSet::from_bytes"));
    let error = ShadowDag::from_bytes(&b"CPVSCUBE"[..]).unwrap_err();
    assert_eq!(error, FileError::Set { lights: 1 });
}

#[test]
fn what_is_no_set_is_refused_by_name() {
    let soup = example();
    let mut bake = begin(&soup, &two_lights());
    assert_eq!(
        ShadowSet::from_bytes(&saved(&bake)).unwrap_err(),
        SetError::Unfinished
    );
    let error = ShadowDag::from_bytes(saved(&bake)).unwrap_err();
    assert_eq!(error, FileError::Unfinished);
    let message = ShadowSet::from_bytes(b"anything").unwrap_err().to_string();
    assert!(message.contains("not a file of shadows"), "{message}");

    let file = baked().to_bytes();
    refuses_damage(&file, 24 + 2 * 32 + 4 * 8);

    // Files are no checkpoints either, nor are those of one grid and earlier ones.
    let earlier = bake.resume(b"CPVSGRID and so on");
    assert_eq!(earlier, Err(CheckpointError::Version(0)));
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
    bake.advance(&Cpu::new(), 150, &never, |_| {}).unwrap();
    assert!(bake.progress().finished == 150);
    let checkpoint = saved(&bake);
    let [a, b, c, d] = lights();
    let refused = |lights: &[LightGrids], soup: &Soup| {
        let mut other = begin(soup, lights);
        let error = other.resume(&checkpoint).unwrap_err();
        assert_eq!(other.progress().finished, 0, "{error}");
        assert!(matches!(error, CheckpointError::Foreign { .. }), "{error}");
    };
    refused(&[grids(&[a, b])], &soup);
    refused(&[grids(&[a, c, b, d])], &soup);
    refused(&[grids(&[a, b]), grids(&[c, d])], &soup);
    refused(&unlike_lights(), &soup);
    refused(&two_lights(), &Soup::of(&[]));

    for cut in (0..checkpoint.len()).step_by(11) {
        let error = begin(&soup, &two_lights()).resume(&checkpoint[..cut]);
        assert!(error.is_err(), "{cut}");
    }
    for at in 0..40 + 2 * 12 + 4 * 160 + 200 {
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
