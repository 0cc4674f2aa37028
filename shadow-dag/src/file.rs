//! Files of shadows: writing them, and believing nothing that is read.

use crate::bytes::{BIT_PADDING, BitWriter, load_bits, load_u32};
use crate::chain;
use crate::file_error::FileError;
use crate::form::Form;
use crate::graph::Graph;
use crate::layout::{CHECKED, Layout, PackedLevel, PlainLevel, Stored};
use crate::nodes::{kind, slot};
use crate::pool::{Children, LIT, Reference, SHADOWED, is_mixed};
use crate::{Error, LightSpace};

/// Puts the checksum into a complete file.
pub(crate) fn seal(bytes: &mut [u8]) {
    let checksum = crc32fast::hash(&bytes[CHECKED..]);
    bytes[CHECKED - 4..CHECKED].copy_from_slice(&checksum.to_le_bytes());
}

/// Bits that numbers below `count` take.
fn bits(count: usize) -> u32 {
    usize::BITS - count.saturating_sub(1).leading_zeros()
}

/// The file of a graph.
///
/// # Errors
/// [`Error::TooManyNodes`] if a level of plain nodes is too long for its
/// references.
pub(crate) fn write(
    graph: &Graph,
    light: Option<&LightSpace>,
    form: Form,
) -> Result<Vec<u8>, Error> {
    let (stored, masks, payload) = match form {
        Form::Plain => {
            let (stored, payload) = plain(graph)?;
            (stored, graph.masks.clone(), payload)
        }
        Form::Packed => packed(graph),
    };
    let head = Layout {
        resolution: graph.resolution,
        root: graph.root,
        light: light.copied(),
        masks: 0,
        mask_count: graph.masks.len() as u32,
        stored,
    };
    let mut bytes = head.write();
    bytes.extend(masks.iter().flat_map(|mask| mask.to_le_bytes()));
    bytes.extend(payload);
    seal(&mut bytes);
    Ok(bytes)
}

fn plain(graph: &Graph) -> Result<(Stored, Vec<u8>), Error> {
    let mut payload = Vec::new();
    let mut levels = Vec::with_capacity(graph.levels.len());
    // Masks keep their numbers.
    let mut below: Option<Vec<Reference>> = None;
    for nodes in &graph.levels {
        let lengths = nodes
            .iter()
            .map(|children| 1 + children.iter().filter(|child| is_mixed(**child)).count() as u64);
        if lengths.sum::<u64>() > u64::from(SHADOWED) {
            return Err(Error::TooManyNodes { limit: SHADOWED });
        }
        let mut words = 0_u32;
        let mut names = Vec::with_capacity(nodes.len());
        for children in nodes {
            names.push(words);
            let mut kinds = 0;
            for (i, &child) in children.iter().enumerate() {
                let kind = match child {
                    SHADOWED => kind::SHADOWED,
                    LIT => kind::LIT,
                    _ => kind::MIXED,
                };
                kinds |= kind << (2 * i);
            }
            payload.extend(kinds.to_le_bytes());
            words += 1;
            for &child in children.iter().filter(|child| is_mixed(**child)) {
                let name = match &below {
                    None => child,
                    Some(names) => names[child as usize],
                };
                payload.extend(name.to_le_bytes());
                words += 1;
            }
        }
        levels.push(PlainLevel {
            start: 0,
            nodes: nodes.len() as u32,
            words,
        });
        below = Some(names);
    }
    Ok((Stored::Plain(levels), payload))
}

/// How far above the mask in front of it one may be that is not stored. More
/// than 1 saves references, but makes more shapes: tried on a city and a
/// landscape, it came out even.
const FURTHEST: u32 = 1;

/// The shape of a node, and its references in the order in which the shape
/// names them. Those that are up to `most` above the one in front of them are
/// left out.
fn shape(children: &Children, most: u32) -> (u32, Vec<Reference>) {
    let mut references: Vec<Reference> = Vec::new();
    let mut shape = 0;
    let mut before = LIT;
    for (i, &child) in children.iter().enumerate() {
        let stored = references.iter().position(|&other| other == child);
        let slot = match (child, stored) {
            (LIT, _) => slot::LIT,
            (SHADOWED, _) => slot::SHADOWED,
            (_, Some(slot)) => slot as u32,
            _ if is_mixed(before) && (before..=before + most).contains(&child) => {
                slot::AFTER + (child - before)
            }
            _ => {
                references.push(child);
                references.len() as u32 - 1
            }
        };
        shape |= slot << (4 * i);
        before = child;
    }
    (shape, references)
}

/// The references of the children of a node, given those that it stores; none
/// if its shape makes no sense.
fn children(shape: u32, stored: &[Reference]) -> Option<Children> {
    let mut found = [LIT; 8];
    let mut before: Option<Reference> = None;
    for (i, child) in found.iter_mut().enumerate() {
        *child = match shape >> (4 * i) & 15 {
            slot::LIT => LIT,
            slot::SHADOWED => SHADOWED,
            slot if slot >= slot::AFTER => before?.checked_add(slot - slot::AFTER)?,
            slot => *stored.get(slot as usize)?,
        };
        before = Some(*child).filter(|child| is_mixed(*child));
    }
    Some(found)
}

fn packed(graph: &Graph) -> (Stored, Vec<u64>, Vec<u8>) {
    let slices = graph.levels.first().map_or(&[][..], Vec::as_slice);
    let mut below = chain::order(graph.masks.len(), slices);
    let mut masks = vec![0; below.len()];
    for (&name, &mask) in below.iter().zip(&graph.masks) {
        masks[name as usize] = mask;
    }
    // Masks by their new numbers, nodes by the old ones.
    let shape_of = |level: usize, children: &Children, below: &[Reference]| {
        let rename = |child: Reference| match below.get(child as usize) {
            Some(&name) if level == 0 && is_mixed(child) => name,
            _ => child,
        };
        shape(&children.map(rename), if level == 0 { FURTHEST } else { 0 })
    };
    // The most frequent shapes have the lowest numbers, so that levels with
    // few of them get by with few bits.
    let mut counts = [const { std::collections::BTreeMap::<u32, u64>::new() }; 2];
    for (level, nodes) in graph.levels.iter().enumerate() {
        for children in nodes {
            *counts[usize::from(level > 0)]
                .entry(shape_of(level, children, &below).0)
                .or_default() += 1;
        }
    }
    let sorted = counts.map(|counts| {
        let mut shapes: Vec<(u32, u64)> = counts.into_iter().collect();
        shapes.sort_by_key(|&(shape, count)| (std::cmp::Reverse(count), shape));
        shapes
            .into_iter()
            .map(|(shape, _)| shape)
            .collect::<Vec<u32>>()
    });
    let numbers = [0, 1].map(|i: usize| {
        (sorted[i].iter().zip(0_u32..))
            .map(|(&shape, number)| (shape, number))
            .collect::<std::collections::HashMap<u32, u32>>()
    });

    let mut payload: Vec<u8> = sorted
        .iter()
        .flatten()
        .flat_map(|shape| shape.to_le_bytes())
        .collect();
    let mut levels = Vec::with_capacity(graph.levels.len());
    for (level, nodes) in graph.levels.iter().enumerate() {
        let shapes: Vec<(u32, Vec<Reference>)> = (nodes.iter())
            .map(|children| {
                let (shape, references) = shape_of(level, children, &below);
                (numbers[usize::from(level > 0)][&shape], references)
            })
            .collect();
        let mut order: Vec<usize> = (0..nodes.len()).collect();
        order.sort_by_key(|&node| shapes[node].1.len());
        let most = shapes.iter().map(|(shape, _)| *shape as usize + 1).max();
        let mut counts = [0; 9];
        for (_, references) in &shapes {
            counts[references.len()] += 1;
        }
        let width = bits(below.len());
        // A file that was not built here may hold equal nodes; numbers of
        // shapes are then wider, so that there can be as many.
        let shape_width = (bits(most.unwrap_or(0))..)
            .find(|shape_width| PackedLevel::can_be(&counts, *shape_width, width))
            .unwrap_or(u32::BITS);
        let mut writer = BitWriter::default();
        let mut names = vec![0; nodes.len()];
        for (&node, name) in order.iter().zip(0_u32..) {
            names[node] = name;
            let (shape, references) = &shapes[node];
            writer.push(*shape, shape_width);
            for &reference in references {
                let name = if level == 0 {
                    reference
                } else {
                    below[reference as usize]
                };
                writer.push(name, width);
            }
        }
        payload.extend(writer.finish());
        // The numbers of a graph fit; where the level begins is only known
        // to who reads it.
        levels.extend(PackedLevel::new(counts, shape_width, width, 0));
        below = names;
    }
    payload.extend([0; BIT_PADDING]);
    let shapes = sorted.map(|shapes| (0, shapes.len() as u32));
    (Stored::Packed { shapes, levels }, masks, payload)
}

/// Checks that a file is as it was written.
pub(crate) fn check_sum(bytes: &[u8]) -> Result<(), FileError> {
    let found = crc32fast::hash(&bytes[CHECKED..]);
    let expected = load_u32(bytes, CHECKED - 4);
    if found != expected {
        return Err(FileError::Checksum { found, expected });
    }
    Ok(())
}

/// Checks everything that a query relies on.
pub(crate) fn validate(bytes: &[u8], layout: &Layout) -> Result<(), FileError> {
    check_sum(bytes)?;
    match &layout.stored {
        Stored::Plain(levels) => validate_plain(bytes, levels, layout.mask_count),
        Stored::Packed { shapes, levels } => {
            validate_packed(bytes, *shapes, levels, layout.mask_count)
        }
    }
}

fn validate_plain(bytes: &[u8], levels: &[PlainLevel], masks: u32) -> Result<(), FileError> {
    // The words of the level below at which nodes begin, one bit each.
    let mut starts: Option<Vec<u64>> = None;
    for (number, level) in levels.iter().enumerate() {
        let word = |at: u32| load_u32(bytes, level.start + 4 * at as usize);
        let mut begins = vec![0_u64; (level.words as usize).div_ceil(64)];
        let (mut at, mut nodes) = (0_u32, 0_u32);
        while at < level.words {
            let error = FileError::Node {
                level: number as u32,
                at,
            };
            let kinds = word(at);
            let mixed = kinds & kind::ALL_MIXED;
            // No fourth kind, no ninth child, and all references are there.
            if kinds & mixed >> 1 != 0 || kinds >> 16 != 0 || mixed.count_ones() >= level.words - at
            {
                return Err(error);
            }
            for i in 1..=mixed.count_ones() {
                let reference = word(at + i) as usize;
                let exists = match &starts {
                    None => reference < masks as usize,
                    Some(starts) => (starts.get(reference / 64))
                        .is_some_and(|bits| bits >> (reference % 64) & 1 == 1),
                };
                if !exists {
                    return Err(error);
                }
            }
            begins[at as usize / 64] |= 1 << (at % 64);
            nodes += 1;
            at += 1 + mixed.count_ones();
        }
        if nodes != level.nodes {
            return Err(FileError::Level {
                level: number as u32,
            });
        }
        starts = Some(begins);
    }
    Ok(())
}

fn validate_packed(
    bytes: &[u8],
    shapes: [(usize, u32); 2],
    levels: &[PackedLevel],
    masks: u32,
) -> Result<(), FileError> {
    let mut below = masks;
    for (number, level) in levels.iter().enumerate() {
        let (shapes, count) = shapes[usize::from(number > 0)];
        for node in 0..level.nodes() {
            let at = level.address(node);
            let references = level.references(node);
            let shape = load_bits(bytes, at, level.shape_width);
            let slots = load_u32(bytes, shapes + 4 * shape as usize);
            let first = at + u64::from(level.shape_width);
            let mut stored = [0; 8];
            for (i, reference) in (0..).zip(&mut stored[..references]) {
                *reference = load_bits(bytes, first + i * u64::from(level.width), level.width);
            }
            let stored = &stored[..references];
            // References that are not stored have to be in range as well.
            let exist = |references: &[Reference]| {
                (references.iter()).all(|reference| *reference < below || !is_mixed(*reference))
            };
            let sound = stored.iter().all(|reference| *reference < below)
                && children(slots, stored).is_some_and(|children| exist(&children));
            if shape >= count || !sound {
                return Err(FileError::Node {
                    level: number as u32,
                    at: node,
                });
            }
        }
        below = level.nodes();
    }
    Ok(())
}
