//! PLY meshes.

mod body;
mod header;
#[cfg(test)]
mod tests;

use glam::Vec3;

use self::body::Body;
use self::header::{Element, Header, Property};
use super::limits::{Budget, Notes};
use super::{LoadError, Loaded, MAX_DECODED_BYTES};
use crate::{MAX_TRIANGLES, Mesh, Scene, SceneError};

/// Reads a PLY file as a scene of one mesh; see the [module](super) for what
/// is understood.
///
/// # Errors
/// [`LoadError::Truncated`], [`LoadError::BadValue`],
/// [`LoadError::Unsupported`], [`LoadError::TooLarge`]; [`LoadError::Scene`]
/// for a face that names a vertex that is not there, for a file without faces
/// and for one with more than [`MAX_TRIANGLES`].
pub fn ply_from_slice(bytes: &[u8]) -> Result<Loaded, LoadError> {
    let header = Header::parse(bytes)?;
    let mut body = Body::new(&bytes[header.length..], header.encoding);
    let mut notes = Notes::default();
    let mut positions = None;
    let mut triangles = None;
    for element in &header.elements {
        if positions.is_some() && triangles.is_some() {
            break;
        }
        let needed = element
            .least_row_bytes(header.encoding)
            .saturating_mul(element.count);
        // The separator after the last value of the file may be missing.
        if needed > body.available() as u64 + 1 {
            return Err(LoadError::truncated(
                format!(
                    "the PLY element \"{}\" of {} rows",
                    element.name, element.count
                ),
                needed,
                body.available(),
            ));
        }
        match element.name.as_str() {
            "vertex" => positions = Some(vertices(element, &mut body, &mut notes)?),
            "face" => triangles = Some(faces(element, &mut body, &mut notes)?),
            _ => skip(element, &mut body)?,
        }
    }
    let (positions, triangles) = (positions.unwrap_or_default(), triangles.unwrap_or_default());
    if triangles.is_empty() {
        return Err(SceneError::Empty.into());
    }
    for &index in triangles.iter().flatten() {
        if index as usize >= positions.len() {
            return Err(LoadError::Scene(SceneError::IndexOutOfRange {
                owner: "a PLY face".into(),
                what: "vertex",
                index: u64::from(index),
                count: positions.len() as u64,
            }));
        }
    }
    let scene = Scene::from(Mesh {
        positions,
        triangles,
        ..Mesh::default()
    });
    Ok(Loaded {
        scene,
        notes: notes.into_vec(),
    })
}

fn vertices(
    element: &Element,
    body: &mut Body<'_>,
    notes: &mut Notes,
) -> Result<Vec<Vec3>, LoadError> {
    let axes: Vec<Option<usize>> = element
        .properties
        .iter()
        .map(|property| match (property.list, property.name.as_str()) {
            (None, "x") => Some(0),
            (None, "y") => Some(1),
            (None, "z") => Some(2),
            _ => None,
        })
        .collect();
    if (0..3).any(|axis| axes.iter().flatten().filter(|&&a| a == axis).count() != 1) {
        return Err(LoadError::bad_value(
            "the properties of a PLY vertex",
            names(&element.properties),
            "x, y and z once each",
        ));
    }
    let others: Vec<&str> = element
        .properties
        .iter()
        .zip(&axes)
        .filter(|(_, axis)| axis.is_none())
        .map(|(property, _)| property.name.as_str())
        .collect();
    if !others.is_empty() {
        notes.add(format!("vertex properties ignored: {}", others.join(", ")));
    }
    Budget::new(MAX_DECODED_BYTES).take("vertices", element.count, size_of::<Vec3>())?;
    // No more than the bytes that are there, which has been checked.
    let mut positions = Vec::with_capacity(element.count as usize);
    for _ in 0..element.count {
        let mut position = Vec3::ZERO;
        for (property, axis) in element.properties.iter().zip(&axes) {
            match axis {
                Some(axis) => position[*axis] = body.number(property.item)? as f32,
                None => skip_property(property, body)?,
            }
        }
        positions.push(position);
    }
    Ok(positions)
}

fn faces(
    element: &Element,
    body: &mut Body<'_>,
    notes: &mut Notes,
) -> Result<Vec<[u32; 3]>, LoadError> {
    let is_corners = |property: &Property| {
        property.list.is_some()
            && property.item.is_integer()
            && matches!(property.name.as_str(), "vertex_indices" | "vertex_index")
    };
    if element.properties.iter().filter(|p| is_corners(p)).count() != 1 {
        return Err(LoadError::bad_value(
            "the properties of a PLY face",
            names(&element.properties),
            "one list of integers called vertex_indices or vertex_index",
        ));
    }
    let (mut polygons, mut slivers) = (0_u64, 0_u64);
    let mut triangles = Vec::with_capacity(element.count.min(MAX_TRIANGLES) as usize);
    for _ in 0..element.count {
        for property in &element.properties {
            let Some(length) = property.list.filter(|_| is_corners(property)) else {
                skip_property(property, body)?;
                continue;
            };
            let count = body.list_length(length, property.item)?;
            polygons += u64::from(count > 3);
            slivers += u64::from(count < 3);
            let (mut first, mut previous) = (0, 0);
            for number in 0..count {
                let corner = body.integer(property.item)?;
                let corner = u32::try_from(corner).map_err(|_| {
                    LoadError::bad_value("a vertex index of a PLY face", corner, "0 to 2^32 - 1")
                })?;
                match number {
                    0 => first = corner,
                    1 => {}
                    _ => triangles.push([first, previous, corner]),
                }
                previous = corner;
                if triangles.len() as u64 > MAX_TRIANGLES {
                    return Err(LoadError::Scene(SceneError::TooManyTriangles {
                        triangles: triangles.len() as u64,
                        limit: MAX_TRIANGLES,
                    }));
                }
            }
        }
    }
    if polygons > 0 {
        notes.add(format!(
            "{polygons} faces of more than three corners were split into fans"
        ));
    }
    if slivers > 0 {
        notes.add(format!(
            "{slivers} faces of less than three corners ignored"
        ));
    }
    Ok(triangles)
}

fn skip(element: &Element, body: &mut Body<'_>) -> Result<(), LoadError> {
    if element.properties.is_empty() {
        // Any number of rows of nothing.
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            skip_property(property, body)?;
        }
    }
    Ok(())
}

fn skip_property(property: &Property, body: &mut Body<'_>) -> Result<(), LoadError> {
    let count = match property.list {
        Some(length) => body.list_length(length, property.item)?,
        None => 1,
    };
    for _ in 0..count {
        body.number(property.item)?;
    }
    Ok(())
}

fn names(properties: &[Property]) -> String {
    let names: Vec<&str> = properties.iter().map(|p| p.name.as_str()).collect();
    format!("[{}]", names.join(", "))
}
