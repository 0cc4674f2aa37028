//! Wavefront OBJ meshes and MTL materials.
//!
//! Text is first reduced to what is read (vertices, texture coordinates, faces
//! with absolute indices, names of bounded length), so that the parsing library
//! gets nothing that it could overflow on, and the memory that it will need is
//! known before it starts.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

use glam::{DVec3, Vec2, Vec3, Vec4};

use super::error::printable;
use super::image::{Encoding, decode};
use super::limits::{Budget, Notes};
use super::place::place;
use super::polygon::Splitter;
use super::{LoadError, LoadOptions, Loaded, MAX_DECODED_BYTES, OpenFile};
use crate::{AlphaMode, Instance, MAX_TRIANGLES, Material, Mesh, Scene, SceneError, Texture};

/// Names of objects, groups and materials are cut off here, bytes: the library
/// copies them for every mesh.
const MAX_NAME: usize = 256;

/// More libraries of materials than this are not opened.
const MAX_LIBRARIES: usize = 64;

/// Bytes that the library and the reader need for each vertex, texture
/// coordinate, corner and face, rounded up.
const VERTEX_BYTES: usize = 256;
const COORDINATE_BYTES: usize = 96;
const CORNER_BYTES: usize = 256;
const FACE_BYTES: usize = 160;

/// Reads an OBJ file; see the [module](super) for what is understood. `open`
/// returns the contents of a material or image file, given its path relative to
/// the scene file.
///
/// # Errors
/// [`LoadError::BadValue`], [`LoadError::TooLarge`]; [`LoadError::Scene`] for a
/// face that names a vertex that is not there, for a file without faces and for
/// one with more than [`MAX_TRIANGLES`]. A material or an image that cannot be
/// read is a note and no error.
pub fn obj_from_slice(
    bytes: &[u8],
    options: &LoadOptions,
    open: OpenFile<'_>,
) -> Result<Loaded, LoadError> {
    options.check()?;
    let mut notes = Notes::default();
    let mut budget = Budget::new(MAX_DECODED_BYTES);
    let reduced = Reduced::of(bytes, &mut notes, &mut budget)?;
    let mut libraries = BTreeMap::new();
    for name in &reduced.libraries {
        match library(name, open, &mut budget) {
            Ok(text) => {
                libraries.insert(name.clone(), text);
            }
            Err(error) => notes.add(format!("materials left out: {error}")),
        }
    }
    let libraries = RefCell::new(libraries);
    let materials_of = |path: &Path| {
        // Each is read once; the library would append it again and again.
        let text = libraries.borrow_mut().remove(&*path.to_string_lossy());
        match text {
            Some(text) => tobj::load_mtl_buf(&mut text.as_bytes()),
            None => Ok(Default::default()),
        }
    };
    let load_options = tobj::LoadOptions {
        ignore_lines: true,
        ignore_points: true,
        ..tobj::LoadOptions::default()
    };
    let loaded = tobj::load_obj_buf(&mut reduced.text.as_bytes(), &load_options, materials_of);
    let (models, materials) = loaded.map_err(|error| not_read(&error))?;
    let materials = materials.unwrap_or_else(|error| {
        notes.add(format!("materials left out: {}", not_read(&error)));
        Vec::new()
    });
    let mut scene = Scene::default();
    let mut images = BTreeMap::new();
    for material in &materials {
        budget.take("materials", 1, size_of::<Material>() + material.name.len())?;
        let material = convert(material, open, &mut images, &mut notes, &mut budget);
        scene.materials.push(material);
    }
    let (mut splitter, mut total) = (Splitter::default(), 0);
    let mut positions = Vec::new();
    for model in &models {
        let mesh = mesh(model, &mut positions, &mut splitter)?;
        total += mesh.triangles.len() as u64;
        if total > MAX_TRIANGLES {
            return Err(LoadError::Scene(SceneError::TooManyTriangles {
                triangles: total,
                limit: MAX_TRIANGLES,
            }));
        }
        if !mesh.triangles.is_empty() {
            scene.instances.push(Instance {
                mesh: scene.meshes.len(),
                ..Instance::default()
            });
            scene.meshes.push(mesh);
        }
    }
    if scene.instances.is_empty() {
        return Err(SceneError::Empty.into());
    }
    if splitter.given_up > 0 {
        notes.add(format!(
            "{} concave faces were split into fans: they have too many corners",
            splitter.given_up
        ));
    }
    let (positions, offset) = place(&positions, options, &mut notes);
    let mut rest = &positions[..];
    for mesh in &mut scene.meshes {
        // As many as the mesh put there, in the same order.
        let (own, others) = rest.split_at(mesh.positions.len());
        mesh.positions.copy_from_slice(own);
        rest = others;
    }
    Ok(Loaded {
        scene,
        notes: notes.into_vec(),
        offset,
    })
}

/// None of the library's errors repeats text of the file.
fn not_read(error: &tobj::LoadError) -> LoadError {
    LoadError::bad_value(
        "an OBJ or MTL file",
        "damaged",
        match error {
            tobj::LoadError::FaceVertexOutOfBounds => "vertices for all corners of its faces",
            tobj::LoadError::FaceTexCoordOutOfBounds => "texture coordinates for all corners",
            tobj::LoadError::MaterialParseError => "numbers and names of files in its materials",
            _ => "lines as the format defines them",
        },
    )
}

fn library(name: &str, open: OpenFile<'_>, budget: &mut Budget) -> Result<String, LoadError> {
    let bytes = open(name)?;
    // Text, and a material for each few bytes of it.
    budget.take("a library of materials", bytes.len() as u64, 32)?;
    let text = String::from_utf8_lossy(&bytes).replace('\r', "\n");
    // A broken number spoils one material, not all of them.
    let is_sound = |line: &&str| {
        let mut words = line.split_whitespace();
        let numbers = |count: usize| {
            let all: Vec<_> = words.clone().skip(1).map(str::parse::<f64>).collect();
            all.len() >= count && all.iter().take(count).all(|n| n.as_ref().is_ok())
        };
        match words.clone().next() {
            Some("Kd" | "Ke") => numbers(3),
            Some("d" | "Tr") => numbers(1),
            Some("newmtl" | "map_Kd" | "map_d") => words.nth(1).is_some(),
            _ => false,
        }
    };
    let mut reduced = String::with_capacity(text.len());
    for line in text.lines().filter(is_sound) {
        let line = line.trim();
        reduced.push_str(cut(line, MAX_NAME + 8));
        reduced.push('\n');
    }
    Ok(reduced)
}

/// The beginning of a text, at most so many bytes.
fn cut(text: &str, bytes: usize) -> &str {
    let mut end = bytes.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    &text[..end]
}

/// An OBJ file without what is not read.
#[derive(Default)]
struct Reduced {
    text: String,
    libraries: BTreeSet<String>,
}

impl Reduced {
    fn of(bytes: &[u8], notes: &mut Notes, budget: &mut Budget) -> Result<Self, LoadError> {
        budget.take("the text of the OBJ file", bytes.len() as u64, 3)?;
        let text = String::from_utf8_lossy(bytes);
        // A backslash joins a line with the next one.
        let text = text
            .replace("\r\n", "\n")
            .replace('\r', "\n")
            .replace("\\\n", " ");
        let mut reduced = Self::default();
        let (mut vertices, mut coordinates, mut coloured) = (0_u64, 0_u64, 0_u64);
        let mut others = 0_u64;
        for line in text.lines() {
            if let Some("v") = line.split_whitespace().next() {
                vertices += 1;
                coloured += u64::from(line.split_whitespace().count() == 7);
            }
        }
        let keeps_colours = coloured == vertices;
        vertices = 0;
        for (number, line) in text.lines().enumerate() {
            let bad = |expected| {
                LoadError::not_understood(
                    format!("line {} of the OBJ file", number + 1),
                    line.as_bytes(),
                    expected,
                )
            };
            let mut words = line.split_whitespace();
            let out = &mut reduced.text;
            match words.next() {
                Some(kind @ ("v" | "vt")) => {
                    let numbers: Result<Vec<f64>, _> = words.take(6).map(str::parse).collect();
                    let numbers = numbers.map_err(|_| bad("numbers"))?;
                    let (least, bytes) = match kind {
                        "v" => (3, VERTEX_BYTES),
                        _ => (1, COORDINATE_BYTES),
                    };
                    if numbers.len() < least {
                        return Err(bad(
                            "three coordinates of a vertex, or one or two of a texture",
                        ));
                    }
                    budget.take("vertices", 1, bytes)?;
                    match (kind, &numbers[..]) {
                        ("v", [x, y, z, w]) if *w != 0.0 => {
                            vertices += 1;
                            push(out, "v", &[x / w, y / w, z / w]);
                        }
                        ("v", numbers) => {
                            vertices += 1;
                            push(out, "v", &numbers[..if keeps_colours { 6 } else { 3 }]);
                        }
                        (_, numbers) => {
                            coordinates += 1;
                            let v = numbers.get(1).copied().unwrap_or(0.0);
                            push(out, "vt", &[numbers[0], v]);
                        }
                    }
                }
                Some("f") => {
                    budget.take("faces", 1, FACE_BYTES)?;
                    out.push('f');
                    for corner in words {
                        budget.take("corners", 1, CORNER_BYTES)?;
                        let mut parts = corner.split('/');
                        let vertex = absolute(parts.next(), vertices).map_err(bad)?;
                        let vertex = vertex.ok_or_else(|| bad("a vertex at each corner"))?;
                        let coordinate = absolute(parts.next(), coordinates).map_err(bad)?;
                        // Writing to a string cannot fail.
                        let _ = write!(out, " {vertex}");
                        if let Some(coordinate) = coordinate {
                            let _ = write!(out, "/{coordinate}");
                        }
                    }
                    out.push('\n');
                }
                Some(kind @ ("o" | "g" | "usemtl")) => {
                    let name = line.trim()[kind.len()..].trim();
                    if !name.is_empty() {
                        let _ = writeln!(out, "{kind} {}", cut(name, MAX_NAME));
                    }
                }
                Some(kind @ "mtllib") => {
                    let name = line.trim()[kind.len()..].trim();
                    if reduced.libraries.len() < MAX_LIBRARIES && !name.is_empty() {
                        let _ = writeln!(out, "mtllib {name}");
                        reduced.libraries.insert(name.to_owned());
                    }
                }
                Some("l" | "p" | "curv" | "surf") => others += 1,
                _ => {}
            }
        }
        if others > 0 {
            notes.add(format!(
                "{others} points, lines, curves and curved surfaces ignored"
            ));
        }
        Ok(reduced)
    }
}

fn push(out: &mut String, kind: &str, numbers: &[f64]) {
    out.push_str(kind);
    for number in numbers {
        // Writing to a string cannot fail.
        let _ = write!(out, " {number:e}");
    }
    out.push('\n');
}

/// An index from 1 up out of one that may count backwards from the last of
/// `count`; `None` if there is none. What was expected if it is none.
fn absolute(text: Option<&str>, count: u64) -> Result<Option<u64>, &'static str> {
    let Some(text) = text.filter(|text| !text.is_empty()) else {
        return Ok(None);
    };
    let index: i64 = text.parse().map_err(|_| "whole numbers in a face")?;
    let index = match index {
        1.. => index as u64,
        0 => return Err("indices other than 0 in a face"),
        _ => (count + 1)
            .checked_sub(index.unsigned_abs())
            .filter(|index| *index > 0)
            .ok_or("indices of what stands before a face")?,
    };
    if index > u64::from(u32::MAX) {
        return Err("indices below 2^32 in a face");
    }
    Ok(Some(index))
}

/// The material, with its images; what cannot be read is left out with a note.
fn convert(
    material: &tobj::Material,
    open: OpenFile<'_>,
    images: &mut BTreeMap<String, Option<Texture>>,
    notes: &mut Notes,
    budget: &mut Budget,
) -> Material {
    let what = format!("material \"{}\"", printable(&material.name));
    let color = |color: [f64; 3], most: f32| {
        let color = Vec3::from_array(color.map(|channel| channel as f32));
        // A clamp passes over a NaN.
        Vec3::select(color.is_nan_mask(), Vec3::ZERO, color).clamp(Vec3::ZERO, Vec3::splat(most))
    };
    let mut texture = |name: &str| -> Option<Texture> {
        // Options come before the name.
        let name = match name.starts_with('-') {
            true => name.split_whitespace().next_back().unwrap_or(name),
            false => name,
        };
        if let Some(known) = images.get(name) {
            return known.clone();
        }
        let bytes = open(&name.replace('\\', "/"));
        let texture = bytes.and_then(|bytes| decode(&bytes, Encoding::Srgb, "an image", budget));
        let texture = texture.map_err(|error| {
            notes.add(format!("the texture of {what} left out: {error}"));
        });
        images.insert(name.to_owned(), texture.clone().ok());
        texture.ok()
    };
    let image = material.diffuse_texture.as_deref().and_then(&mut texture);
    let plain = if image.is_some() { [1.0; 3] } else { [0.8; 3] };
    let transparent = material.unknown_param.get("Tr");
    let transparent = transparent.and_then(|t| t.split_whitespace().next()?.parse::<f64>().ok());
    let opacity = material.dissolve.or(transparent.map(|t| 1.0 - t));
    let opacity = (opacity.unwrap_or(1.0) as f32).clamp(0.0, 1.0);
    let opacity = if opacity.is_nan() { 1.0 } else { opacity };
    let has_map = material.dissolve_texture.is_some();
    let is_own_alpha = has_map && material.dissolve_texture == material.diffuse_texture;
    if has_map && !is_own_alpha {
        notes.add(format!(
            "map_d of {what} ignored: it is another image than map_Kd"
        ));
    }
    let is_opaque = opacity == 1.0 && !is_own_alpha;
    Material {
        name: material.name.clone(),
        base_color: color(material.diffuse.unwrap_or(plain), 1.0),
        base_color_texture: image,
        emitted: color(material.emissive.unwrap_or([0.0; 3]), 1e20),
        opacity,
        alpha: if is_opaque {
            AlphaMode::Opaque
        } else {
            AlphaMode::Blend
        },
        ..Material::default()
    }
}

/// A mesh whose positions are still to come; they are appended to `positions`.
fn mesh(
    model: &tobj::Model,
    positions: &mut Vec<DVec3>,
    splitter: &mut Splitter,
) -> Result<Mesh, LoadError> {
    let source = &model.mesh;
    let triple = |list: &[f64], at: u32| {
        let at = 3 * at as usize;
        DVec3::new(list[at], list[at + 1], list[at + 2])
    };
    let has_coordinates = source.texcoord_indices.len() == source.indices.len();
    // Vertices of a position and a texture coordinate each.
    let mut known = BTreeMap::new();
    let start = positions.len();
    let (mut texture_coordinates, mut colors) = (Vec::new(), Vec::new());
    let mut corners = Vec::with_capacity(source.indices.len());
    for (number, &position) in source.indices.iter().enumerate() {
        let coordinate = has_coordinates.then(|| source.texcoord_indices[number]);
        let next = known.len() as u32;
        let index = *known.entry((position, coordinate)).or_insert(next);
        if index == next {
            positions.push(triple(&source.positions, position));
            if let Some(at) = coordinate {
                let at = 2 * at as usize;
                let uv = [source.texcoords[at], source.texcoords[at + 1]];
                texture_coordinates.push(Vec2::new(uv[0] as f32, 1.0 - uv[1] as f32));
            }
            if !source.vertex_color.is_empty() {
                let color = triple(&source.vertex_color, position).as_vec3();
                let color = Vec3::select(color.is_nan_mask(), Vec3::ZERO, color);
                colors.push(color.clamp(Vec3::ZERO, Vec3::ONE).extend(1.0));
            }
        }
        corners.push(index);
    }
    let own = &positions[start..];
    let mut triangles = Vec::new();
    let mut rest = &corners[..];
    // No arities: triangles throughout.
    let arities = source.face_arities.iter().map(|arity| *arity as usize);
    let arities: Vec<usize> = match source.face_arities.is_empty() {
        true => vec![3; corners.len() / 3],
        false => arities.collect(),
    };
    for arity in arities {
        let Some((face, others)) = rest.split_at_checked(arity) else {
            break;
        };
        splitter.split(face, own, &mut triangles);
        rest = others;
        if triangles.len() as u64 > MAX_TRIANGLES {
            return Err(LoadError::Scene(SceneError::TooManyTriangles {
                triangles: triangles.len() as u64,
                limit: MAX_TRIANGLES,
            }));
        }
    }
    let colors: Vec<Vec4> = colors;
    if triangles.is_empty() {
        positions.truncate(start);
    }
    Ok(Mesh {
        name: model.name.clone(),
        positions: vec![Vec3::ZERO; positions.len() - start],
        texture_coordinates,
        colors,
        triangles,
        material: source.material_id,
        ..Mesh::default()
    })
}

#[cfg(test)]
mod tests;
