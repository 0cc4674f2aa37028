//! NanoVDB files of fog volumes: grids of `float`, uncompressed or ZIP.
//!
//! The format is that of the library's header, version 32: a header, a record per
//! grid, and each grid as one block of nodes that refer to each other by offsets. A
//! root of tiles of 4096³ voxels, below it nodes of 32³ children, of 16³, and leaves
//! of 8³ voxels.

use std::borrow::Cow;
use std::collections::HashMap;

use glam::{DMat3, DVec3};

use super::limits::{Budget, Notes};
use super::voxels::{self, Dense, Placement, VoxelGrid};
use super::words::Words;
use super::{LoadError, LoadOptions, Loaded, MAX_DECODED_BYTES, zip};

/// Reads a NanoVDB file as a scene of one density grid; see the [module](super)
/// for what is understood.
///
/// # Errors
/// [`LoadError::Truncated`], [`LoadError::BadValue`],
/// [`LoadError::Unsupported`], [`LoadError::TooLarge`]; [`LoadError::Scene`]
/// for a density, an emission or a transform that [`DensityGrid`](crate::DensityGrid)
/// refuses.
pub fn nvdb_from_slice(bytes: &[u8], options: &LoadOptions) -> Result<Loaded, LoadError> {
    options.check()?;
    let mut notes = Notes::default();
    let mut budget = Budget::new(MAX_DECODED_BYTES);
    let grids = find_grids(bytes, &mut notes)?;
    let [density, emission] = voxels::chosen(Tree::FORMAT, grids, &mut notes)?;
    let mut tree = |stored: Option<_>| {
        let tree = |stored| Tree::new(StoredGrid::unpacked(stored, &mut budget)?);
        stored.map(tree).transpose()
    };
    let grids = [tree(density)?, tree(emission)?];
    voxels::scene_of(grids, options, &mut budget, notes)
}

/// Numbers of `nanovdb::GridType` and `nanovdb::GridClass`.
const FLOAT: u32 = 1;
const LEVEL_SET: u32 = 1;

/// One grid of the file.
#[derive(Debug)]
struct StoredGrid<'a> {
    codec: u16,
    /// Bytes once they are unpacked.
    size: u64,
    bytes: &'a [u8],
}

/// The grids of the type `float` with their names. A file is one segment behind the other,
/// each of some grids.
fn find_grids<'a>(
    bytes: &'a [u8],
    notes: &mut Notes,
) -> Result<Vec<(String, StoredGrid<'a>)>, LoadError> {
    let mut words = Words::new(bytes);
    let mut found = Vec::new();
    loop {
        let records = read_segment(&mut words)?;
        for record in records {
            let bytes = words.bytes("a NanoVDB grid", record.stored)?;
            if record.is_fog {
                let grid = StoredGrid {
                    codec: record.codec,
                    size: record.size,
                    bytes,
                };
                found.push((record.name, grid));
            } else {
                voxels::left_out(&record.name, notes);
            }
        }
        let rest = words.available();
        if rest == 0 {
            break;
        }
        if !words.starts_with(b"NanoVDB") {
            notes.add(format!("{rest} bytes after the last grid ignored"));
            break;
        }
    }
    Ok(found)
}

/// What the list of grids tells of one.
#[derive(Debug)]
struct Record {
    name: String,
    is_fog: bool,
    codec: u16,
    /// Bytes once they are unpacked, and in the file.
    size: u64,
    stored: u64,
}

/// The head of a segment and its list of grids.
fn read_segment(words: &mut Words<'_>) -> Result<Vec<Record>, LoadError> {
    let what = "the header of a NanoVDB file";
    let magic = words.item::<8>(what)?;
    if !matches!(&magic, b"NanoVDB0" | b"NanoVDB2") {
        return Err(LoadError::not_understood(
            "the start of the file",
            &magic,
            "\"NanoVDB0\" or \"NanoVDB2\"",
        ));
    }
    check_version(words.u32(what)?)?;
    let count = u16::from_le_bytes(words.item(what)?);
    words.item::<2>(what)?;
    let what = "the list of NanoVDB grids";
    let mut records = Vec::new();
    for _ in 0..count {
        let size = u64::from_le_bytes(words.item(what)?);
        let stored = u64::from_le_bytes(words.item(what)?);
        words.item::<16>(what)?;
        let (kind, class) = (words.u32(what)?, words.u32(what)?);
        words.item::<96>(what)?;
        let name_length = words.u32(what)?;
        words.item::<28>(what)?;
        let codec = u16::from_le_bytes(words.item(what)?);
        words.item::<6>(what)?;
        let name = words.bytes(what, name_length.into())?;
        let name = name.split(|&byte| byte == 0).next().unwrap_or_default();
        records.push(Record {
            name: String::from_utf8_lossy(name).into_owned(),
            is_fog: kind == FLOAT && class != LEVEL_SET,
            codec,
            size,
            stored,
        });
    }
    Ok(records)
}

/// The layout is that of the major version.
fn check_version(version: u32) -> Result<(), LoadError> {
    match version >> 21 {
        32 => Ok(()),
        major => Err(LoadError::Unsupported(format!(
            "NanoVDB of the major version {major}"
        ))),
    }
}

impl<'a> StoredGrid<'a> {
    fn unpacked(self, budget: &mut Budget) -> Result<Cow<'a, [u8]>, LoadError> {
        match self.codec {
            0 => Ok(Cow::Borrowed(self.bytes)),
            1 => {
                let what = "a compressed NanoVDB grid";
                let mut words = Words::new(self.bytes);
                let length = u64::from_le_bytes(words.item(what)?);
                let packed = words.bytes(what, length)?;
                budget.take(what, self.size, 1)?;
                let most = usize::try_from(self.size).unwrap_or(usize::MAX);
                zip::unpacked(what, packed, most).map(Cow::Owned)
            }
            2 => Err(LoadError::Unsupported(
                "BLOSC compression of NanoVDB".into(),
            )),
            codec => Err(LoadError::bad_value("the NanoVDB codec", codec, "0 to 2")),
        }
    }
}

/// Sizes and offsets of the nodes of a tree of floats, bytes.
mod layout {
    pub(super) const GRID: usize = 672;
    pub(super) const MATRIX: usize = 296 + 88;
    pub(super) const VECTOR: usize = 296 + 232;
    pub(super) const ROOT_OFFSET: usize = 24;
    pub(super) const BACKGROUND: usize = 28;
    pub(super) const ROOT: usize = 64;
    pub(super) const TILE: usize = 32;
    pub(super) const TILE_VALUE: usize = 20;
    /// Masks of children, and tables of values and offsets, of the two inner levels.
    pub(super) const UPPER: (usize, usize) = (4128, 8256);
    pub(super) const LOWER: (usize, usize) = (544, 1088);
    pub(super) const LEAF_VALUES: usize = 96;
}

/// A grid of floats.
#[derive(Debug)]
struct Tree<'a> {
    bytes: Cow<'a, [u8]>,
    placement: Placement,
    background: f32,
    /// Of the voxels that are there, least and greatest included.
    indices: [[i32; 3]; 2],
    /// Root tiles by their keys: where they are in the file.
    tiles: HashMap<u64, usize>,
    root: usize,
}

/// A block of 8³ voxels.
#[derive(Debug, Clone, Copy)]
enum Block {
    Constant(f32),
    /// Where its leaf begins.
    Leaf(usize),
}

impl<'a> Tree<'a> {
    fn new(bytes: Cow<'a, [u8]>) -> Result<Self, LoadError> {
        let at = |place: usize| Reader {
            bytes: &bytes,
            place,
        };
        let magic = at(0).bytes::<8>()?;
        if !matches!(&magic, b"NanoVDB0" | b"NanoVDB1") {
            return Err(LoadError::not_understood(
                "the start of a NanoVDB grid",
                &magic,
                "\"NanoVDB0\" or \"NanoVDB1\"",
            ));
        }
        check_version(at(16).u32()?)?;
        let mut matrix = [0.0; 12];
        let places = (0..9).map(|i| layout::MATRIX + 8 * i);
        let places = places.chain((0..3).map(|i| layout::VECTOR + 8 * i));
        for (number, place) in matrix.iter_mut().zip(places) {
            *number = f64::from_le_bytes(at(place).bytes()?);
        }
        let [turn @ .., x, y, z] = matrix;
        // Rows of the file are columns of the transpose.
        let turn = DMat3::from_cols_array(&turn).transpose();
        let root = at(layout::GRID + layout::ROOT_OFFSET).follow(layout::GRID)?;
        let corner = |first: usize| -> Result<[i32; 3], LoadError> {
            let number = |axis: usize| at(root + first + 4 * axis).u32();
            Ok([number(0)?, number(1)?, number(2)?].map(|word| word.cast_signed()))
        };
        let indices = [corner(0)?, corner(12)?];
        let count = at(root + 24).u32()?;
        let mut tiles = HashMap::new();
        for index in 0..count as usize {
            // A table longer than the file ends here, before it is stored.
            let tile = root + layout::ROOT + layout::TILE * index;
            at(tile + layout::TILE - 1).bytes::<1>()?;
            tiles.entry(at(tile).u64()?).or_insert(tile);
        }
        let background = at(root + layout::BACKGROUND).f32()?;
        Ok(Self {
            placement: Placement {
                turn,
                shift: DVec3::new(x, y, z),
            },
            background,
            indices,
            tiles,
            root,
            bytes,
        })
    }

    fn at(&self, place: usize) -> Reader<'_> {
        Reader {
            bytes: &self.bytes,
            place,
        }
    }

    /// The block whose least voxel has these indices, which are those of an i32.
    fn block(&self, corner: [i64; 3]) -> Result<Block, LoadError> {
        let [x, y, z] = corner.map(|index| (index as i32).cast_unsigned());
        let key = u64::from(z >> 12) | u64::from(y >> 12) << 21 | u64::from(x >> 12) << 42;
        let Some(&tile) = self.tiles.get(&key) else {
            return Ok(Block::Constant(self.background));
        };
        if self.at(tile + 8).u64()? == 0 {
            return Ok(Block::Constant(self.at(tile + layout::TILE_VALUE).f32()?));
        }
        let mut node = self.at(tile + 8).follow(self.root)?;
        for (bits, below, (mask, table)) in [(5, 7, layout::UPPER), (4, 3, layout::LOWER)] {
            let part = |index: u32| (index >> below) as usize & ((1 << bits) - 1);
            let index = (part(x) << (2 * bits)) | (part(y) << bits) | part(z);
            let [byte] = self.at(node + mask + index / 8).bytes::<1>()?;
            let entry = self.at(node + table + 8 * index);
            if byte >> (index % 8) & 1 == 0 {
                return Ok(Block::Constant(entry.f32()?));
            }
            node = entry.follow(node)?;
        }
        Ok(Block::Leaf(node))
    }

    fn leaf(&self, node: usize, corner: [i64; 3], dense: &mut Dense) -> Result<(), LoadError> {
        let values = self.at(node + layout::LEAF_VALUES).bytes::<2048>()?;
        let (values, _) = values.as_chunks::<4>();
        dense.leaf(corner, |index| f32::from_le_bytes(values[index]));
        Ok(())
    }
}

impl VoxelGrid for Tree<'_> {
    const FORMAT: &'static str = "NanoVDB";

    fn indices(&self) -> Option<[[i64; 3]; 2]> {
        let [low, high] = self.indices.map(|corner| corner.map(i64::from));
        let is_filled = (0..3).all(|axis| low[axis] <= high[axis]);
        is_filled.then_some([low, high])
    }

    fn placement(&self) -> Placement {
        self.placement
    }

    fn background(&self) -> f32 {
        self.background
    }

    fn fill(&self, dense: &mut Dense) -> Result<(), LoadError> {
        let Some([low, high]) = self.indices() else {
            return Ok(());
        };
        let [x, y, z] = [0, 1, 2].map(|axis| (low[axis] >> 3)..=(high[axis] >> 3));
        for bz in z {
            for by in y.clone() {
                for bx in x.clone() {
                    let corner = [bx, by, bz].map(|block| block << 3);
                    match self.block(corner)? {
                        Block::Constant(value) if value == self.background => {}
                        Block::Constant(value) => {
                            dense.fill([corner, corner.map(|index| index + 7)], value);
                        }
                        Block::Leaf(leaf) => self.leaf(leaf, corner, dense)?,
                    }
                }
            }
        }
        Ok(())
    }
}

/// A place in a grid.
#[derive(Debug, Clone, Copy)]
struct Reader<'a> {
    bytes: &'a [u8],
    place: usize,
}

impl Reader<'_> {
    fn bytes<const N: usize>(&self) -> Result<[u8; N], LoadError> {
        let found = self.bytes.get(self.place..).and_then(<[u8]>::first_chunk);
        found.copied().ok_or_else(|| {
            let needed = (self.place as u64).saturating_add(N as u64);
            LoadError::truncated("a NanoVDB grid", needed, self.bytes.len())
        })
    }

    fn u32(&self) -> Result<u32, LoadError> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }

    fn u64(&self) -> Result<u64, LoadError> {
        Ok(u64::from_le_bytes(self.bytes()?))
    }

    fn f32(&self) -> Result<f32, LoadError> {
        Ok(f32::from_le_bytes(self.bytes()?))
    }

    /// The place that the number here is away from `base`: within the grid.
    fn follow(&self, base: usize) -> Result<usize, LoadError> {
        let offset = i64::from_le_bytes(self.bytes()?);
        let place = i64::try_from(base).ok();
        let place = place.and_then(|base| base.checked_add(offset));
        let place = place.and_then(|place| usize::try_from(place).ok());
        place
            .filter(|&place| place < self.bytes.len())
            .ok_or_else(|| {
                let expected = "a place in the grid";
                LoadError::bad_value("an offset of a NanoVDB node", offset, expected)
            })
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::{DensityGrid, Translucent};

    /// Written by `nanovdb_convert -z` of OpenVDB 10.0.1: voxels (i, j, k) from (−3,
    /// 0, 6) to (5, 3, 10) of the density ((7i + 3j + 5k) mod 11)/8 + 1/4, a tile of
    /// 8³ voxels of ½ from (16, 0, 8) on, and a transform to (½i + 1, ¼j + 2, ½k + 3).
    const DENSITY: &[u8] = include_bytes!("testdata/density.nvdb");
    /// The same, with a grid called temperature beside it.
    const TWO: &[u8] = include_bytes!("testdata/two.nvdb");
    /// A grid of vectors.
    const VECTORS: &[u8] = include_bytes!("testdata/vectors.nvdb");

    /// Offsets in these files: the record of the first grid, and its data.
    const RECORD: usize = 16;
    const DATA: usize = RECORD + 176 + 8;

    fn read(file: &[u8]) -> Result<Loaded, LoadError> {
        nvdb_from_slice(file, &LoadOptions::default())
    }

    fn grid(file: &[u8]) -> DensityGrid {
        match read(file).unwrap().scene.translucent.remove(0) {
            Translucent::Grid(grid) => grid,
            other => panic!("{other:?}"),
        }
    }

    /// The nodes of the first grid.
    fn nodes() -> Vec<u8> {
        miniz_oxide::inflate::decompress_to_vec_zlib(&DENSITY[DATA + 8..]).unwrap()
    }

    /// The same file with these nodes, not compressed.
    fn with_nodes(nodes: &[u8]) -> Vec<u8> {
        let mut file = DENSITY[..DATA].to_vec();
        let length = (nodes.len() as u64).to_le_bytes();
        file[RECORD..RECORD + 8].copy_from_slice(&length);
        file[RECORD + 8..RECORD + 16].copy_from_slice(&length);
        file[RECORD + 168..RECORD + 170].copy_from_slice(&[0; 2]);
        file.extend(nodes);
        file
    }

    #[test]
    fn voxels_tiles_and_the_transform_are_those_of_the_file() {
        for file in [DENSITY.to_vec(), with_nodes(&nodes()), TWO.to_vec()] {
            let grid = grid(&file);
            assert_eq!(grid.resolution(), [29, 10, 12]);
            let (mut voxels, mut tile) = (0, 0);
            for i in -4_i32..25 {
                for j in -1..9 {
                    for k in 5..17 {
                        let index = ((k - 5) * 10 + (j + 1)) * 29 + (i + 4);
                        let density = grid.density()[index as usize];
                        let is_voxel =
                            (-3..6).contains(&i) && (0..4).contains(&j) && (6..11).contains(&k);
                        let is_tile =
                            (16..24).contains(&i) && (0..8).contains(&j) && (8..16).contains(&k);
                        let expected = if is_voxel {
                            voxels += 1;
                            (7 * i + 3 * j + 5 * k).rem_euclid(11) as f32 / 8.0 + 0.25
                        } else if is_tile {
                            tile += 1;
                            0.5
                        } else {
                            0.0
                        };
                        assert_eq!(density, expected, "{i} {j} {k}");
                    }
                }
            }
            assert_eq!((voxels, tile), (180, 512));
            let there = Vec3::new(0.5 * 2.0 + 1.0, 0.25 + 2.0, 0.5 * 9.0 + 3.0);
            let expected = (14 + 3 + 45) % 11;
            let found = grid.extinction_at(there);
            assert!((found - (expected as f32 / 8.0 + 0.25)).abs() < 1e-5);
            // Half a voxel outside half of the density is left.
            let outside = Vec3::new(0.5 * 23.5 + 1.0, 0.25 * 4.0 + 2.0, 0.5 * 12.0 + 3.0);
            assert!((grid.extinction_at(outside) - 0.25).abs() < 1e-5);
        }
        let notes = read(TWO).unwrap().notes;
        assert!(
            notes.iter().any(|note| note.contains("temperature")),
            "{notes:?}"
        );
    }

    #[test]
    fn unit_and_up_axis_turn_the_grid_and_keep_optical_depths() {
        use super::super::UpAxis;
        let plain = grid(DENSITY);
        let options = LoadOptions {
            unit: 0.5,
            up: UpAxis::Z,
            ..LoadOptions::default()
        };
        let turned = match nvdb_from_slice(DENSITY, &options)
            .unwrap()
            .scene
            .translucent
            .remove(0)
        {
            Translucent::Grid(grid) => grid,
            other => panic!("{other:?}"),
        };
        let place = Vec3::new(1.3, 2.4, 7.2);
        let there = 0.5 * Vec3::new(place.x, place.z, -place.y);
        let (was, is) = (plain.extinction_at(place), turned.extinction_at(there));
        assert!(was > 0.1 && (is - 2.0 * was).abs() < 1e-4, "{was} {is}");
    }

    #[test]
    fn bad_files_are_refused_with_their_cause() {
        let with = |place: usize, bytes: &[u8]| {
            let mut file = DENSITY.to_vec();
            file[place..place + bytes.len()].copy_from_slice(bytes);
            file
        };
        let node = |place: usize, bytes: &[u8]| {
            let mut nodes = nodes();
            nodes[place..place + bytes.len()].copy_from_slice(bytes);
            with_nodes(&nodes)
        };
        let root = layout::GRID + 64;
        for (file, cause) in [
            (b"NanoVDB9".to_vec(), "\"NanoVDB0\""),
            (with(8, &[0, 0, 0, 1]), "major version 8"),
            (with(12, &[9, 0]), "list of NanoVDB grids needs"),
            (with(RECORD, &[255; 8]), "more than the limit"),
            (with(RECORD, &[1]), "ZLIB"),
            (with(RECORD + 8, &[255; 8]), "a NanoVDB grid needs"),
            (with(RECORD + 32, &[13]), "without a grid"),
            (with(RECORD + 36, &[1]), "without a grid"),
            (with(RECORD + 136, &[255; 4]), "list of NanoVDB grids needs"),
            (with(RECORD + 168, &[2]), "BLOSC"),
            (with(RECORD + 168, &[7]), "codec is 7"),
            (with(DATA + 30, &[99; 30]), "ZLIB"),
            (node(0, b"NanoVDB2"), "start of a NanoVDB grid"),
            (node(layout::GRID + 24, &[255; 8]), "a NanoVDB grid needs"),
            (
                node(layout::GRID + 24, &[255, 255, 255, 255, 0, 0, 0, 0]),
                "place in the grid",
            ),
            (node(root + 24, &[255; 4]), "a NanoVDB grid needs"),
            (node(root, &[255, 255, 255, 127]), "at least one voxel"),
            (node(root + 12, &[255, 255, 255, 127]), "grid of "),
            (
                node(root + 64 + 8, &i64::MAX.to_le_bytes()),
                "place in the grid",
            ),
            (node(layout::MATRIX, &[0; 8]), "transform"),
            (node(layout::MATRIX, &[255; 8]), "transform"),
        ] {
            let error = read(&file).map(|_| cause).unwrap_err().to_string();
            assert!(error.contains(cause), "{cause}: {error}");
        }
        let error = read(VECTORS).unwrap_err().to_string();
        assert!(error.contains("float"), "{error}");
    }

    #[test]
    fn every_truncation_is_an_error_and_more_bytes_are_a_note() {
        for length in 0..DENSITY.len() {
            assert!(read(&DENSITY[..length]).is_err(), "{length}");
        }
        let nodes = nodes();
        for length in (0..nodes.len()).step_by(1009) {
            assert!(read(&with_nodes(&nodes[..length])).is_err(), "{length}");
        }
        let longer = [DENSITY, &[0]].concat();
        assert!(read(&longer).unwrap().notes[0].starts_with("1 bytes"));
    }

    #[test]
    fn damage_never_panics() {
        // The lists, in front of ever so little of the grid.
        let mut head = DENSITY[..DATA + 64].to_vec();
        head[RECORD + 8..RECORD + 16].copy_from_slice(&64_u64.to_le_bytes());
        head[DATA..DATA + 8].copy_from_slice(&56_u64.to_le_bytes());
        crate::load::damage::survives(&head, |damaged| drop(read(damaged)));
        let mut random = reference::random::Random::new(3);
        for _ in 0..100 {
            let mut damaged = TWO.to_vec();
            let place = DATA + random.below((TWO.len() - DATA) as u32) as usize;
            damaged[place] = random.bits() as u8;
            drop(read(&damaged));
        }
        // Damage to the nodes' own numbers, most of which are tables of nothing.
        let nodes = nodes();
        let telling = [0, 672, 736, 800, 832, 864];
        for _ in 0..300 {
            let mut damaged = nodes.clone();
            for _ in 0..4 {
                let start = telling[random.below(6) as usize] as usize;
                let place = start + random.below(64) as usize;
                damaged[place] = random.bits() as u8;
            }
            drop(read(&with_nodes(&damaged)));
        }
    }
}
