use glam::Vec3;

use super::*;
use crate::load::UpAxis;
use crate::load::voxels::Dense;
use crate::{DensityGrid, Translucent};

// Files written by OpenVDB 10.0.1, each in ZLIB data. The first four hold what
// `density.nvdb` does: voxels (i, j, k) from (−3, 0, 6) to (5, 3, 10) of the density
// ((7i + 3j + 5k) mod 11)/8 + 1/4, a tile of 8³ voxels of ½ from (16, 0, 8) on, and a
// transform to (½i + 1, ¼j + 2, ½k + 3).

/// Blosc, without inactive values.
const BLOSC: &[u8] = include_bytes!("../testdata/blosc.vdb.zz");
/// ZIP, without inactive values.
const ZIP: &[u8] = include_bytes!("../testdata/zip.vdb.zz");
/// Not compressed, with inactive values.
const NONE: &[u8] = include_bytes!("../testdata/none.vdb.zz");
/// Like the first, as half floats.
const HALF: &[u8] = include_bytes!("../testdata/half.vdb.zz");
/// Seven leaves from (8n, 0, 0) on whose inactive values are of the kinds 0 to 6, around
/// a background of ½. Voxels at (i, j, k) of a leaf are active where i + 2j + 3k is a
/// multiple of 5, with 1 + ((i + j + k) mod 16)/8. A tile from (0, 8, 0) on is 7, and not
/// active. (i, j, k) is at (5 − 2j, 6 + 2i, 7 + 3k).
const INACTIVE: &[u8] = include_bytes!("../testdata/inactive.vdb.zz");
/// Vectors called velocity, a level set, flames, the same called heat, and the densities
/// of the first four. Flames are (i + j + k)/4 from (4, −2, 6) to (7, 1, 9). Each (i, j,
/// k) is at half of that.
const SEVERAL: &[u8] = include_bytes!("../testdata/several.vdb.zz");
/// The flames alone.
const FLAMES: &[u8] = include_bytes!("../testdata/flames.vdb.zz");
/// A grid called other, and one called density that shares its nodes, which are those of
/// the first four.
const INSTANCE: &[u8] = include_bytes!("../testdata/instance.vdb.zz");

fn file(packed: &[u8]) -> Vec<u8> {
    miniz_oxide::inflate::decompress_to_vec_zlib(packed).unwrap()
}

fn read(file: &[u8]) -> Result<Loaded, LoadError> {
    vdb_from_slice(file, &LoadOptions::default())
}

fn grid(file: &[u8]) -> DensityGrid {
    match read(file).unwrap().scene.translucent.remove(0) {
        Translucent::Grid(grid) => grid,
        other => panic!("{other:?}"),
    }
}

/// The density at a voxel of the first four files.
fn density(i: i32, j: i32, k: i32) -> f32 {
    if (-3..6).contains(&i) && (0..4).contains(&j) && (6..11).contains(&k) {
        return (7 * i + 3 * j + 5 * k).rem_euclid(11) as f32 / 8.0 + 0.25;
    }
    let is_tile = (16..24).contains(&i) && (0..8).contains(&j) && (8..16).contains(&k);
    if is_tile { 0.5 } else { 0.0 }
}

/// All indices of a grid of which the first sample has this one, x fastest.
fn indices(first: [i32; 3], resolution: [u32; 3]) -> impl Iterator<Item = [i32; 3]> {
    let [x, y, z] = [0, 1, 2].map(|axis| first[axis]..first[axis] + resolution[axis] as i32);
    z.flat_map(move |k| {
        let x = x.clone();
        y.clone()
            .flat_map(move |j| x.clone().map(move |i| [i, j, k]))
    })
}

#[test]
fn voxels_tiles_and_the_transform_are_those_of_the_file() {
    for packed in [BLOSC, ZIP, NONE, HALF] {
        let grid = grid(&file(packed));
        assert_eq!(grid.resolution(), [29, 10, 12]);
        for ([i, j, k], &found) in indices([-4, -1, 5], [29, 10, 12]).zip(grid.density()) {
            assert_eq!(found, density(i, j, k), "{i} {j} {k}");
        }
        let there = Vec3::new(0.5 * 2.0 + 1.0, 0.25 + 2.0, 0.5 * 9.0 + 3.0);
        assert!((grid.extinction_at(there) - density(2, 1, 9)).abs() < 1e-5);
        // Half a voxel outside half of the density is left.
        let outside = Vec3::new(0.5 * 23.5 + 1.0, 0.25 * 4.0 + 2.0, 0.5 * 12.0 + 3.0);
        assert!((grid.extinction_at(outside) - 0.25).abs() < 1e-5);
        assert!(read(&file(packed)).unwrap().notes.is_empty());
    }
}

#[test]
fn inactive_values_are_what_each_node_says() {
    let file = file(INACTIVE);
    let mut notes = Notes::default();
    let [(name, stored)] = &find_grids(&file, &mut notes).unwrap()[..] else {
        panic!("one grid");
    };
    assert_eq!(name, "density");
    let tree = Tree::new(stored, &mut Budget::new(1 << 20)).unwrap();
    assert_eq!(tree.background(), 0.5);
    assert_eq!(tree.indices(), Some([[0; 3], [55, 7, 7]]));
    let resolution = [58, 10, 10];
    let values = Dense::of(&tree, [-1; 3], resolution).unwrap();
    for ([x, j, k], &found) in indices([-1; 3], resolution).zip(&values) {
        let is_there = (0..56).contains(&x) && (0..8).contains(&j) && (0..8).contains(&k);
        let (leaf, i) = (x.div_euclid(8), x.rem_euclid(8));
        let place = (i + 2 * j + 3 * k) % 5;
        let choose = |odd, even| if place % 2 == 1 { odd } else { even };
        let expected = match (is_there, leaf) {
            (false, _) => 0.0,
            _ if place == 0 => 1.0 + 0.125 * ((i + j + k) % 16) as f32,
            (_, 0) => 0.5,
            (_, 1) => -0.5,
            (_, 2) => 4.0,
            (_, 3) => choose(0.5, -0.5),
            (_, 4) => choose(0.5, 4.0),
            (_, 5) => choose(6.0, 4.0),
            _ => place as f32,
        };
        assert_eq!(found, expected, "{x} {j} {k}");
    }
    // Inactive tiles count where they are within the box of active voxels.
    let there = tree.placement().turn * DVec3::new(1.0, 2.0, 3.0) + tree.placement().shift;
    assert_eq!(there, DVec3::new(5.0 - 4.0, 6.0 + 2.0, 7.0 + 9.0));
    let error = read(&file).unwrap_err().to_string();
    assert!(error.contains("density is -0.5"), "{error}");
}

#[test]
fn of_several_grids_the_density_and_the_flames_are_read() {
    let file = file(SEVERAL);
    let loaded = read(&file).unwrap();
    for name in ["velocity", "surface", "heat"] {
        let note = format!("the grid \"{name}\" is left out");
        assert!(loaded.notes.contains(&note), "{:?}", loaded.notes);
    }
    assert!(loaded.notes.iter().any(|note| note.contains("flames")));
    let grid = grid(&file);
    // Around both, one voxel wider.
    assert_eq!(grid.resolution(), [29, 12, 12]);
    let values = grid.density().iter().zip(grid.emission());
    for ([i, j, k], (&found, &emitted)) in indices([-4, -3, 5], [29, 12, 12]).zip(values) {
        assert_eq!(found, density(i, j, k));
        let emits = (4..8).contains(&i) && (-2..2).contains(&j) && (6..10).contains(&k);
        let expected = if emits {
            0.25 * (i + j + k) as f32
        } else {
            0.0
        };
        assert_eq!(emitted, Vec3::splat(expected), "{i} {j} {k}");
    }
}

#[test]
fn flames_alone_emit_without_any_density() {
    let grid = grid(&file(FLAMES));
    assert_eq!(grid.resolution(), [6; 3]);
    assert!(grid.density().iter().all(|&density| density == 0.0));
    for ([i, j, k], &emitted) in indices([3, -3, 5], [6; 3]).zip(grid.emission()) {
        let emits = (4..8).contains(&i) && (-2..2).contains(&j) && (6..10).contains(&k);
        let expected = if emits {
            0.25 * (i + j + k) as f32
        } else {
            0.0
        };
        assert_eq!(emitted, Vec3::splat(expected), "{i} {j} {k}");
    }
}

#[test]
fn a_grid_that_shares_the_nodes_of_another_has_them() {
    let grid = grid(&file(INSTANCE));
    for ([i, j, k], &found) in indices([-4, -1, 5], [29, 10, 12]).zip(grid.density()) {
        assert_eq!(found, density(i, j, k), "{i} {j} {k}");
    }
    let first = grid.transform().transform_point3(Vec3::ZERO);
    assert_eq!(first, Vec3::new(-2.0, -0.5, 2.5));
}

#[test]
fn unit_and_up_axis_turn_the_grid_and_keep_optical_depths() {
    let file = file(SEVERAL);
    let plain = grid(&file);
    let options = LoadOptions {
        unit: 0.5,
        up: UpAxis::Z,
        ..LoadOptions::default()
    };
    let loaded = vdb_from_slice(&file, &options).unwrap();
    let [Translucent::Grid(turned)] = &loaded.scene.translucent[..] else {
        panic!("a grid");
    };
    let place = Vec3::new(1.3, 0.4, 4.2);
    let there = 0.5 * Vec3::new(place.x, place.z, -place.y);
    let (was, is) = (plain.extinction_at(place), turned.extinction_at(there));
    assert!(was > 0.1 && (is - 2.0 * was).abs() < 1e-4, "{was} {is}");
    assert_eq!(turned.emission().len(), plain.emission().len());
    for (was, is) in plain.emission().iter().zip(turned.emission()) {
        assert_eq!(2.0 * *was, *is);
    }
}

/// Where in a file of one grid of densities something is: its descriptor, its
/// compression, its transform and its nodes.
struct Places {
    descriptor: usize,
    /// Where it is said where the grid ends.
    end: usize,
    compression: usize,
    transform: usize,
    nodes: usize,
}

impl Places {
    fn of(file: &[u8]) -> Self {
        let find = |text: &[u8]| {
            let mut windows = file.windows(text.len());
            windows.position(|window| window == text).unwrap()
        };
        let transform = find(b"ScaleTranslateMap") + 17;
        Self {
            descriptor: find(b"density") - 4,
            end: find(b"Tree_float_5_4_3") + 16 + 4 + 16,
            compression: find(b"Tree_float_5_4_3") + 16 + 4 + 24,
            transform,
            nodes: transform + 18 * 8,
        }
    }
}

#[test]
fn bad_files_are_refused_with_their_cause() {
    let good = file(BLOSC);
    let with = |place: usize, bytes: &[u8]| {
        let mut file = good.clone();
        file[place..place + bytes.len()].copy_from_slice(bytes);
        file
    };
    let places = Places::of(&good);
    let kind = places.descriptor + 11 + 4;
    // The root, and its first node behind its corner and masks.
    let root = places.nodes + 8;
    let values = root + 8 + 12 + 2 * 4096;
    for (file, cause) in [
        (with(0, b"X"), "the start of the file"),
        (with(8, &[221]), "version 221"),
        (with(8, &[225]), "version 225"),
        (with(20, &[0]), "a stream"),
        (with(57, &[255; 4]), "metadata of an OpenVDB grid needs"),
        (with(61, &[9]), "list of OpenVDB grids needs"),
        (with(places.descriptor, &[255; 4]), "list of OpenVDB grids"),
        (with(kind, b"Tree_int32"), "without a grid of densities"),
        (with(kind + 20, &[1]), "place of an OpenVDB grid"),
        (with(kind + 44 - 8, &[0; 8]), "place of an OpenVDB grid"),
        (with(kind + 44 - 4, &[1]), "an OpenVDB grid needs"),
        (with(places.compression, &[8]), "expected 0 to 7"),
        (with(places.compression + 4, &[255; 4]), "metadata of an"),
        (with(places.transform - 17, b"X"), "kind of transform"),
        (with(places.transform + 24, &[0; 8]), "transform"),
        (with(places.transform, &[255; 8]), "transform"),
        (with(places.nodes, &[2]), "2 values per voxel"),
        (with(root, &[255; 4]), "the nodes of an OpenVDB grid needs"),
        (with(root + 8, &[1]), "place of a node"),
        (with(values, &[7]), "kind of inactive values"),
        (with(values + 1, &[255; 8]), "expected the length"),
        (
            with(values + 1, &[0, 0, 1]),
            "values of an OpenVDB node needs",
        ),
    ] {
        let error = read(&file).map(|_| cause).unwrap_err().to_string();
        assert!(error.contains(cause), "{cause}: {error}");
    }
    // A grid in the place of its parent, and of another class.
    let instance = file(INSTANCE);
    let at = instance.windows(5).position(|name| name == b"other");
    let mut orphan = instance.clone();
    orphan[at.unwrap()] = b'x';
    let error = read(&orphan).unwrap_err().to_string();
    assert!(error.contains("shares its nodes with is other"), "{error}");
    let class = good.windows(10).position(|class| class == b"fog volume");
    let mut surface = good.clone();
    surface[class.unwrap()..][..10].copy_from_slice(b"level set\0");
    surface[class.unwrap() - 4] = 9;
    let error = read(&surface).unwrap_err().to_string();
    assert!(error.contains("OpenVDB"), "{error}");
}

#[test]
fn every_affine_transform_is_read() {
    let read = |kind: &str, numbers: &[f64]| {
        let mut bytes = (kind.len() as u32).to_le_bytes().to_vec();
        bytes.extend(kind.bytes());
        bytes.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        read_transform(&mut Words::new(&bytes))
    };
    let numbers: Vec<f64> = (1..19).map(f64::from).collect();
    let point = DVec3::new(1.0, 10.0, 100.0);
    for (kind, count, expected) in [
        ("UniformScaleMap", 15, [1.0, 20.0, 300.0]),
        ("ScaleMap", 15, [1.0, 20.0, 300.0]),
        ("UniformScaleTranslateMap", 18, [5.0, 52.0, 603.0]),
        ("ScaleTranslateMap", 18, [5.0, 52.0, 603.0]),
        ("TranslationMap", 3, [2.0, 12.0, 103.0]),
        ("AffineMap", 16, [964.0, 1076.0, 1188.0]),
        ("UnitaryMap", 16, [964.0, 1076.0, 1188.0]),
    ] {
        let placement = read(kind, &numbers[..count]).unwrap();
        let found = placement.turn * point + placement.shift;
        assert_eq!(found.to_array(), expected, "{kind}");
        assert!(read(kind, &numbers[..count - 1]).is_err(), "{kind}");
    }
    let error = read("NonlinearFrustumMap", &numbers)
        .unwrap_err()
        .to_string();
    assert!(error.contains("frustum"), "{error}");
}

#[test]
fn every_truncation_is_an_error_and_more_bytes_are_a_note() {
    let file = file(BLOSC);
    let places = Places::of(&file);
    let node = places.nodes + 60;
    for length in (0..node).chain((node..file.len()).step_by(199)) {
        assert!(read(&file[..length]).is_err(), "{length}");
    }
    // The same where the list of grids agrees.
    for length in (places.compression..file.len()).step_by(101) {
        let mut short = file[..length].to_vec();
        short[places.end..places.end + 8].copy_from_slice(&(length as u64).to_le_bytes());
        assert!(read(&short).is_err(), "{length}");
    }
    let longer = [&file[..], &[0]].concat();
    assert!(read(&longer).unwrap().notes[0].starts_with("1 bytes"));
}

#[test]
fn damage_never_panics() {
    for packed in [BLOSC, ZIP, NONE] {
        let file = file(packed);
        // What is in front of the nodes, and ever so little of these.
        let length = 700;
        let mut head = file[..length].to_vec();
        let end = Places::of(&file).end;
        head[end..end + 8].copy_from_slice(&(length as u64).to_le_bytes());
        crate::load::damage::survives(&head, |damaged| drop(read(damaged)));
        // Most bytes are masks of nothing.
        let telling: Vec<usize> = (0..file.len()).filter(|&at| file[at] != 0).collect();
        let mut random = reference::random::Random::new(3);
        for _ in 0..100 {
            let mut damaged = file.clone();
            for _ in 0..=random.below(3) {
                let place = random.below(telling.len() as u32) as usize;
                damaged[telling[place]] = random.bits() as u8;
            }
            drop(read(&damaged));
        }
    }
}
