//! OpenVDB files of fog volumes: grids of `float`, also those that were saved as half
//! floats; values as they are or packed by ZIP or Blosc, with or without inactive ones.
//!
//! The format is that of the library's sources, versions 222 to 224 of it: a header, and
//! each grid with a descriptor in front that says where it ends. A grid is its metadata,
//! its transform, its topology (all nodes, depth first, with their masks and tiles) and
//! the values of its leaves in the same order.

mod blosc;
mod tree;
mod values;

#[cfg(test)]
mod tests;

use std::collections::HashMap;

use glam::{DMat3, DVec3};

use self::tree::Tree;
use self::values::Packing;
use super::limits::{Budget, Notes};
use super::voxels::{self, Placement, VoxelGrid};
use super::words::Words;
use super::{LoadError, LoadOptions, Loaded, MAX_DECODED_BYTES, OPEN_VDB, printable, zip};

/// Reads an OpenVDB file as a scene of one density grid; see the [module](super)
/// for what is understood.
///
/// # Errors
/// [`LoadError::Truncated`], [`LoadError::BadValue`],
/// [`LoadError::Unsupported`], [`LoadError::TooLarge`]; [`LoadError::Scene`]
/// for a density, an emission or a transform that [`DensityGrid`](crate::DensityGrid)
/// refuses.
pub fn vdb_from_slice(bytes: &[u8], options: &LoadOptions) -> Result<Loaded, LoadError> {
    options.check()?;
    let mut notes = Notes::default();
    let mut budget = Budget::new(MAX_DECODED_BYTES);
    let grids = find_grids(bytes, &mut notes)?;
    let [density, emission] = voxels::chosen(Tree::FORMAT, grids, &mut notes)?;
    let mut tree = |grid: Option<_>| {
        let tree = |grid| Tree::new(&grid, &mut budget);
        grid.map(tree).transpose()
    };
    let grids = [tree(density)?, tree(emission)?];
    voxels::scene_of(grids, options, &mut budget, notes)
}

/// One grid of the file.
#[derive(Debug, Clone, Copy)]
struct StoredGrid<'a> {
    is_fog: bool,
    placement: Placement,
    packing: Packing,
    /// From its topology on.
    nodes: &'a [u8],
}

/// Types of grids that are read.
const FLOAT: &[u8] = b"Tree_float_5_4_3";
const FLOAT_AS_HALF: &[u8] = b"Tree_float_5_4_3_HalfFloat";

/// What separates the name of a grid from the number that tells it from others of the
/// same name.
const SEPARATOR: u8 = 0x1e;

/// The grids of the type `float` with their names.
fn find_grids<'a>(
    bytes: &'a [u8],
    notes: &mut Notes,
) -> Result<Vec<(String, StoredGrid<'a>)>, LoadError> {
    let mut words = Words::new(bytes);
    read_header(&mut words)?;
    read_metadata(&mut words)?;
    let what = "the list of OpenVDB grids";
    let count = words.u32(what)?;
    let mut found = Vec::new();
    // By their unique names, for others that share their nodes.
    let mut known: HashMap<&[u8], StoredGrid<'a>> = HashMap::new();
    for _ in 0..count {
        let unique = read_text(&mut words, what)?;
        let kind = read_text(&mut words, what)?;
        let parent = read_text(&mut words, what)?;
        let places = [words.item(what)?, words.item(what)?, words.item(what)?];
        let [start, _, end] = places.map(u64::from_le_bytes);
        let here = (bytes.len() - words.available()) as u64;
        let length = end.checked_sub(here).filter(|_| start == here);
        let Some(length) = length else {
            let what = "the place of an OpenVDB grid";
            let value = format!("{start} to {end}");
            return Err(LoadError::bad_value(
                what,
                value,
                "one behind its descriptor",
            ));
        };
        let grid = words.bytes("an OpenVDB grid", length)?;
        let name = unique.split(|&byte| byte == SEPARATOR).next();
        let name = String::from_utf8_lossy(name.unwrap_or_default());
        let is_half = kind == FLOAT_AS_HALF;
        if !(is_half || kind == FLOAT) {
            voxels::left_out(&name, notes);
            continue;
        }
        let mut grid = StoredGrid::read(grid, is_half)?;
        if !parent.is_empty() {
            let Some(other) = known.get(parent) else {
                let what = "the grid that another OpenVDB grid shares its nodes with";
                let name = printable(&String::from_utf8_lossy(parent));
                return Err(LoadError::bad_value(what, name, "one in front of it"));
            };
            (grid.packing, grid.nodes) = (other.packing, other.nodes);
        }
        known.insert(unique, grid);
        match grid.is_fog {
            true => found.push((name.into_owned(), grid)),
            false => voxels::left_out(&name, notes),
        }
    }
    let rest = words.available();
    if rest > 0 {
        notes.add(format!("{rest} bytes after the last grid ignored"));
    }
    Ok(found)
}

fn read_header(words: &mut Words<'_>) -> Result<(), LoadError> {
    let what = "the header of an OpenVDB file";
    let magic = words.item::<8>(what)?;
    if magic != OPEN_VDB {
        let (what, expected) = ("the start of the file", "the number of OpenVDB files");
        return Err(LoadError::not_understood(what, &magic, expected));
    }
    let version = words.u32(what)?;
    if !(222..=224).contains(&version) {
        return Err(LoadError::Unsupported(format!(
            "version {version} of OpenVDB files (222 to 224 are read)"
        )));
    }
    // The version of the library.
    words.item::<8>(what)?;
    let [has_places] = words.item(what)?;
    if has_places == 0 {
        let what = "an OpenVDB file that was written as a stream, without places of its grids,";
        return Err(LoadError::Unsupported(what.into()));
    }
    // A random number of the file.
    words.item::<36>(what)?;
    Ok(())
}

/// A text with its length in front.
fn read_text<'a>(words: &mut Words<'a>, what: &str) -> Result<&'a [u8], LoadError> {
    let length = words.u32(what)?;
    words.bytes(what, length.into())
}

/// Whether the metadata are those of a level set, of which nothing else matters here.
fn read_metadata(words: &mut Words<'_>) -> Result<bool, LoadError> {
    let what = "the metadata of an OpenVDB grid";
    let count = words.u32(what)?;
    let mut is_level_set = false;
    for _ in 0..count {
        let name = read_text(words, what)?;
        let kind = read_text(words, what)?;
        let value = read_text(words, what)?;
        is_level_set |= name == b"class" && kind == b"string" && value == b"level set";
    }
    Ok(is_level_set)
}

impl<'a> StoredGrid<'a> {
    fn read(bytes: &'a [u8], is_half: bool) -> Result<Self, LoadError> {
        let mut words = Words::new(bytes);
        let flags = words.u32("the compression of an OpenVDB grid")?;
        let packing = Packing::new(flags, is_half)?;
        let is_fog = !read_metadata(&mut words)?;
        let placement = read_transform(&mut words)?;
        let nodes = words.bytes("an OpenVDB grid", words.available() as u64)?;
        Ok(Self {
            is_fog,
            placement,
            packing,
            nodes,
        })
    }
}

/// From indices to the space of the file.
fn read_transform(words: &mut Words<'_>) -> Result<Placement, LoadError> {
    let what = "the transform of an OpenVDB grid";
    let kind = read_text(words, what)?;
    let mut numbers = |count: u64| -> Result<Vec<f64>, LoadError> {
        Ok(words.items(what, count)?.map(f64::from_le_bytes).collect())
    };
    let vector = |numbers: &[f64]| DVec3::new(numbers[0], numbers[1], numbers[2]);
    // Behind scales are four other vectors that follow from them.
    Ok(match kind {
        b"UniformScaleMap" | b"ScaleMap" => Placement {
            turn: DMat3::from_diagonal(vector(&numbers(15)?)),
            shift: DVec3::ZERO,
        },
        b"UniformScaleTranslateMap" | b"ScaleTranslateMap" => {
            let numbers = numbers(18)?;
            Placement {
                turn: DMat3::from_diagonal(vector(&numbers[3..])),
                shift: vector(&numbers),
            }
        }
        b"TranslationMap" => Placement {
            turn: DMat3::IDENTITY,
            shift: vector(&numbers(3)?),
        },
        b"AffineMap" | b"UnitaryMap" => {
            // Rows of the file, which multiplies from the other side, are columns.
            let numbers = numbers(16)?;
            let row = |first: usize| vector(&numbers[first..]);
            Placement {
                turn: DMat3::from_cols(row(0), row(4), row(8)),
                shift: row(12),
            }
        }
        b"NonlinearFrustumMap" => {
            let what = "an OpenVDB grid in the shape of a frustum";
            return Err(LoadError::Unsupported(what.into()));
        }
        other => {
            let expected = "that of a scale, a translation or an affine map";
            let what = "the kind of transform of an OpenVDB grid";
            return Err(LoadError::not_understood(what, other, expected));
        }
    })
}
