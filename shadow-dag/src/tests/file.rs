use glam::{DMat4, IVec3, UVec2, Vec3};
use gpu_backend::Cpu;
use proptest::prelude::*;

use super::maps;
use crate::{Builder, FileError, FilterSize, Form, LightSpace, Ray, ShadowDag};

/// Asks everything once.
fn ask<B: AsRef<[u8]>>(dag: &ShadowDag<B>) {
    let n = dag.resolution().side().min(1 << 12) as i32;
    for i in 0..64 {
        let at = IVec3::new(i * 37 % n, i * 11 % n, i * 5 % n);
        let _ = dag.is_lit(at);
        let _ = dag.filter(at, FilterSize::new(9).unwrap());
        let _ = dag.filter_bilinear(at.as_vec3() + 0.3, FilterSize::new(3).unwrap());
        let _ = dag.depth(UVec2::new(at.x as u32, at.y as u32));
        let _ = dag.visibility(at, at + 9);
        if n <= 64 {
            let ray = Ray::new(at.as_vec3(), Vec3::new(0.3, 0.7, -0.5), f32::INFINITY).unwrap();
            let _ = dag.lit_intervals(&ray);
        }
    }
    let _ = dag.sizes();
    let _ = dag.upload(&Cpu::single_threaded());
}

/// Asks for another form, and that for what was there.
fn turn<B: AsRef<[u8]> + Clone>(dag: &ShadowDag<B>) -> Result<(), TestCaseError> {
    let bare = dag.clone().with_top_grid(0);
    let packed = dag.to_form(Form::Packed).unwrap();
    let plain = packed.to_form(Form::Plain).unwrap();
    for other in [&plain, &packed] {
        let read = ShadowDag::from_bytes(other.as_bytes());
        prop_assert!(read.is_ok(), "{:?}", read);
    }
    let n = dag.resolution().side() as i32;
    for i in 0..64 {
        let at = IVec3::new(i * 37 % n, i * 1111 % n, i * 50_005 % n);
        let lit = dag.is_lit(at);
        prop_assert_eq!(
            [bare.is_lit(at), packed.is_lit(at), plain.is_lit(at)],
            [lit; 3]
        );
    }
    Ok(())
}

/// The file of shadows: plain, packed or compressed.
fn in_form(dag: &ShadowDag, form: usize) -> Vec<u8> {
    match form {
        0 => dag.to_form(Form::Plain).unwrap().into_bytes(),
        1 => dag.to_form(Form::Packed).unwrap().into_bytes(),
        _ => dag.compress(),
    }
}

/// A file with the checksum that its content has.
fn seal(bytes: &mut [u8]) {
    if bytes.len() > 16 {
        let sum = crc32fast::hash(&bytes[16..]);
        bytes[12..16].copy_from_slice(&sum.to_le_bytes());
    }
}

proptest! {
    #![proptest_config(reference::property::cases(2000))]

    #[test]
    fn bytes_of_any_kind_are_answered_or_an_error(
        head in prop_oneof![Just(0_usize), Just(8), Just(12), Just(16)],
        log2 in prop_oneof![Just(3_u32), 3..=20_u32, any::<u32>()],
        form in 0..4_u32,
        counts in proptest::collection::vec(
            prop_oneof![Just(0_u32), 0..4_u32, Just(u32::MAX - 1), any::<u32>()], 0..60),
        rest in proptest::collection::vec(any::<u8>(), 0..300),
    ) {
        // As much of a true head as `head` says, and a light that is not known.
        let mut bytes = b"CPVSDAG\0\x01\0\0\0\0\0\0\0".to_vec();
        bytes.truncate(head);
        for word in [form, log2, counts.first().copied().unwrap_or(u32::MAX), 0] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.resize(bytes.len() + 152, 0);
        bytes.extend(counts.iter().flat_map(|count| count.to_le_bytes()));
        bytes.extend(rest);
        seal(&mut bytes);
        if let Ok(read) = ShadowDag::read(&bytes) {
            ask(&read);
            turn(&read)?;
        }
    }

    #[test]
    fn damaged_files_with_a_true_checksum_are_answered_or_an_error(
        map in prop_oneof![maps::arbitrary(8), maps::noise(8), maps::arbitrary(16)],
        form in 0..3_usize,
        flips in proptest::collection::vec((any::<prop::sample::Index>(), 0..8_u32), 1..5),
        cut in proptest::option::weighted(0.2, any::<prop::sample::Index>()),
    ) {
        let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
        let good = in_form(&dag, form);
        let mut bytes = good;
        for (at, bit) in flips {
            let at = at.index(bytes.len());
            bytes[at] ^= 1 << bit;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        seal(&mut bytes);
        if let Ok(read) = ShadowDag::read(&bytes) {
            ask(&read);
            turn(&read)?;
        }
    }
}

proptest! {
    #![proptest_config(reference::property::cases(64))]

    #[test]
    fn forms_and_files_turn_into_each_other_without_loss(
        map in prop_oneof![maps::arbitrary(64), maps::noise(16), maps::arbitrary(8)],
        shift in 0..8_usize,
    ) {
        let plain = Builder::new().build(&Cpu::new(), &map).unwrap();
        let packed = plain.to_form(Form::Packed).unwrap();
        prop_assert_eq!((plain.form(), packed.form()), (Form::Plain, Form::Packed));
        prop_assert!(packed.to_form(Form::Plain).unwrap().as_bytes() == plain.as_bytes());
        prop_assert!(packed.to_form(Form::Packed).unwrap().as_bytes() == packed.as_bytes());
        for dag in [&plain, &packed] {
            let compressed = dag.compress();
            let read = ShadowDag::read(&compressed).unwrap();
            prop_assert!(read.as_bytes() == packed.as_bytes());
            prop_assert!(read.compress() == compressed);
            prop_assert_eq!(read.light(), dag.light());
        }
        for dag in [plain, packed] {
            // At any alignment, borrowed.
            let mut bytes = vec![0; shift];
            bytes.extend(dag.as_bytes());
            let read = ShadowDag::from_bytes(&bytes[shift..]).unwrap();
            prop_assert_eq!(read.graph(), dag.graph());
            prop_assert_eq!(read.resolution(), dag.resolution());
        }
    }

    #[test]
    fn damaged_files_are_errors_and_never_panic(
        map in maps::arbitrary(32),
        form in 0..3_usize,
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        cut in proptest::option::of(any::<prop::sample::Index>()),
        resealed: bool,
    ) {
        let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
        let good = in_form(&dag, form);
        let mut bytes = good.clone();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        if resealed {
            seal(&mut bytes);
        }
        match ShadowDag::read(&bytes) {
            Ok(read) => {
                prop_assert!(resealed || bytes == good);
                ask(&read);
            }
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }

    #[test]
    fn words_in_the_head_and_in_nodes_are_not_believed(
        map in maps::arbitrary(32),
        form in 0..3_usize,
        at in any::<prop::sample::Index>(),
        value in prop_oneof![
            Just(u32::MAX), Just(u32::MAX - 1), Just(u32::MAX - 2), Just(0), Just(1 << 31), any::<u32>(),
        ],
    ) {
        let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
        let good = in_form(&dag, form);
        let mut bytes = good;
        let at = 4 * at.index(bytes.len() / 4);
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        seal(&mut bytes);
        if let Ok(read) = ShadowDag::read(&bytes) {
            ask(&read);
        }
    }

    #[test]
    fn bytes_that_change_while_they_are_mapped_give_answers_but_no_panic(
        map in maps::arbitrary(32),
        form in 0..2_usize,
        noise in proptest::collection::vec(any::<u8>(), 64),
    ) {
        use std::cell::RefCell;
        use std::rc::Rc;
        /// Memory that somebody else writes to: every look at it can differ.
        struct Shared(Rc<RefCell<&'static [u8]>>);
        impl AsRef<[u8]> for Shared {
            fn as_ref(&self) -> &[u8] {
                *self.0.borrow()
            }
        }
        let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
        let good = in_form(&dag, form);
        let bytes: &'static [u8] = good.leak();
        let shared = Rc::new(RefCell::new(bytes));
        let read = ShadowDag::from_bytes(Shared(shared.clone())).unwrap();
        let mut changed = bytes.to_vec();
        for (i, byte) in changed.iter_mut().enumerate().skip(184) {
            *byte ^= noise[i % noise.len()];
        }
        for bytes in [changed.leak(), &mut []] {
            shared.replace(bytes);
            ask(&read);
        }
    }
}

#[test]
fn the_light_is_kept_in_the_file() {
    let map = maps::named(16).remove(0).1;
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    assert_eq!(dag.light(), None);
    let view = DMat4::from_rotation_x(0.7);
    for light in [
        LightSpace::orthographic(view, 3.0, 4.0, -1.0, 9.0).unwrap(),
        LightSpace::perspective(view, 1.2, 0.1, 50.0).unwrap(),
    ] {
        let dag = ShadowDag::from_graph(&dag.graph(), Some(&light), Form::Packed).unwrap();
        let read = ShadowDag::from_bytes(dag.as_bytes()).unwrap();
        assert_eq!(read.light(), Some(&light));
    }
}

#[test]
fn nodes_that_cost_no_bytes_are_an_error() {
    // All far: a graph without nodes.
    let map = maps::named(16).remove(3).1;
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    let mut bytes = dag.to_form(Form::Packed).unwrap().into_bytes();
    // The first number of the table of levels: nodes without references, whose
    // shapes take no bits.
    bytes[192..196].copy_from_slice(&(u32::MAX - 1).to_le_bytes());
    seal(&mut bytes);
    let error = ShadowDag::from_bytes(bytes).unwrap_err();
    assert_eq!(error, FileError::Level { level: 0 });
}

#[test]
fn files_with_equal_nodes_can_be_packed() {
    let map = maps::named(16).remove(3).1;
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    let mut bytes = dag.as_bytes()[..184].to_vec();
    // The root is node 0; no masks.
    bytes[24..32].fill(0);
    // Two nodes of two lit slices each, which are the first two octants.
    for word in [2, 2, 1, 3_u32, 0b0101, 0b0101, 0b1010, 0, 1] {
        bytes.extend(word.to_le_bytes());
    }
    seal(&mut bytes);
    let read = ShadowDag::from_bytes(bytes).unwrap();
    assert!(read.is_lit(IVec3::new(8, 0, 1)) && !read.is_lit(IVec3::new(8, 0, 2)));
    turn(&read).unwrap();
}

#[test]
fn errors_say_what_is_wrong() {
    let map = maps::named(16).remove(4).1;
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    let good = dag.as_bytes();
    let with = |at: usize, value: u32| {
        let mut bytes = good.to_vec();
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        seal(&mut bytes);
        ShadowDag::from_bytes(bytes).unwrap_err()
    };
    assert_eq!(with(0, 0), FileError::Magic);
    assert_eq!(with(8, 2), FileError::Version(2));
    assert!(matches!(with(16, 7), FileError::Header { value: 7, .. }));
    assert!(matches!(with(20, 31), FileError::Header { value: 31, .. }));
    assert!(matches!(with(24, 5), FileError::Header { value: 5, .. }));
    assert!(matches!(with(28, u32::MAX), FileError::Truncated { .. }));
    assert!(matches!(with(32, 3), FileError::Header { value: 3, .. }));
    assert!(matches!(with(32, 1), FileError::Light));
    let read = |bytes: &[u8]| ShadowDag::from_bytes(bytes).map(|_| ()).unwrap_err();
    assert!(matches!(read(&[]), FileError::Truncated { .. }));
    assert!(matches!(read(b"PNG"), FileError::Magic));
    assert!(matches!(
        read(&good[..good.len() - 1]),
        FileError::Truncated { .. }
    ));
    assert!(matches!(
        read(&[good, &[0]].concat()),
        FileError::TooLong { .. }
    ));
    let mut bytes = good.to_vec();
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    assert!(matches!(read(&bytes), FileError::Checksum { .. }));
}

#[test]
fn compressed_files_are_smaller_and_have_to_be_decoded() {
    let map = maps::named(64).remove(0).1;
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    let packed = dag.to_form(Form::Packed).unwrap();
    let compressed = dag.compress();
    assert!(compressed.len() < packed.as_bytes().len());
    let error = ShadowDag::from_bytes(&compressed).unwrap_err();
    assert_eq!(error, FileError::Compressed);
    assert!(error.to_string().contains("ShadowDag::read"));
    let mut damaged = compressed.clone();
    damaged[186] ^= 1;
    assert!(matches!(
        ShadowDag::read(&damaged),
        Err(FileError::Checksum { .. })
    ));
    // Not as many masks as are announced.
    damaged = compressed;
    damaged[28] ^= 1;
    seal(&mut damaged);
    assert_eq!(ShadowDag::read(&damaged).unwrap_err(), FileError::Code);
    damaged[24..28].copy_from_slice(&7_u32.to_le_bytes());
    seal(&mut damaged);
    assert!(matches!(
        ShadowDag::read(&damaged),
        Err(FileError::Header { value: 7, .. })
    ));
}

#[test]
fn few_bytes_never_decode_to_many_nodes() {
    let map = maps::named(16).remove(3).1;
    let dag = Builder::new().build(&Cpu::new(), &map).unwrap();
    let mut decoded = 0;
    for byte in 0..=u8::MAX {
        for count in [0, 1, 40, 400] {
            let mut bytes = dag.compress()[..184].to_vec();
            // The finest grid, with a root that is a node.
            bytes[20..24].copy_from_slice(&20_u32.to_le_bytes());
            bytes[24..28].fill(0);
            bytes.resize(184 + count, byte);
            for masks in 0..3_u32 {
                bytes[28..32].copy_from_slice(&masks.to_le_bytes());
                seal(&mut bytes);
                match ShadowDag::read(&bytes) {
                    Ok(read) => {
                        let levels = read.sizes().levels;
                        let nodes = levels.iter().map(|level| level.nodes as usize);
                        assert!(nodes.sum::<usize>() <= 2 * count + 18);
                        ask(&read);
                        decoded += 1;
                    }
                    Err(error) => assert_eq!(error, FileError::Code),
                }
            }
        }
    }
    assert!(decoded > 0);
}
