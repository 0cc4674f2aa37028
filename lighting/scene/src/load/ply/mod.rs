//! PLY meshes.

mod body;
mod header;
#[cfg(test)]
mod tests;

use glam::DVec3;

use self::body::Body;
use self::header::{Element, Header, Property};
use super::error::printable;
use super::limits::{Budget, Notes};
use super::place::place;
use super::polygon::Splitter;
use super::{LoadError, LoadOptions, Loaded, MAX_DECODED_BYTES};
use crate::{MAX_TRIANGLES, Mesh, Scene, SceneError};

/// Reads a PLY file as a scene of one mesh; see the [module](super) for what
/// is understood.
///
/// # Errors
/// [`LoadError::Truncated`], [`LoadError::BadValue`],
/// [`LoadError::Unsupported`], [`LoadError::TooLarge`]; [`LoadError::Scene`]
/// for a face that names a vertex that is not there, for a file without faces
/// and for one with more than [`MAX_TRIANGLES`].
pub fn ply_from_slice(bytes: &[u8], options: &LoadOptions) -> Result<Loaded, LoadError> {
    options.check()?;
    let header = Header::parse(bytes)?;
    let mut body = Body::new(&bytes[header.length..], header.encoding);
    let mut notes = Notes::default();
    let mut budget = Budget::new(MAX_DECODED_BYTES);
    let mut positions = None;
    let mut faces = None;
    let has_faces = header.elements.iter().any(|e| e.name == "face");
    for element in &header.elements {
        if positions.is_some() && faces.is_some() {
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
                    printable(&element.name),
                    element.count
                ),
                needed,
                body.available(),
            ));
        }
        match element.name.as_str() {
            "vertex" => positions = Some(vertices(element, &mut body, &mut notes, &mut budget)?),
            "face" => faces = Some(Faces::read(element, &mut body, &mut budget)?),
            "tristrips" if !has_faces => {
                faces = Some(Faces::read_strips(element, &mut body, &mut budget)?);
            }
            _ => skip(element, &mut body)?,
        }
    }
    let (positions, faces) = (positions.unwrap_or_default(), faces.unwrap_or_default());
    let triangles = faces.triangles(&positions, &mut notes, &mut budget)?;
    if triangles.is_empty() {
        return Err(SceneError::Empty.into());
    }
    let (positions, offset) = place(&positions, options, &mut notes);
    let scene = Scene::from(Mesh {
        positions,
        triangles,
        ..Mesh::default()
    });
    Ok(Loaded {
        scene,
        notes: notes.into_vec(),
        offset,
    })
}

fn vertices(
    element: &Element,
    body: &mut Body<'_>,
    notes: &mut Notes,
    budget: &mut Budget,
) -> Result<Vec<DVec3>, LoadError> {
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
    let others: Vec<String> = element
        .properties
        .iter()
        .zip(&axes)
        .filter(|(_, axis)| axis.is_none())
        .map(|(property, _)| printable(&property.name))
        .collect();
    if !others.is_empty() {
        notes.add(format!("vertex properties ignored: {}", others.join(", ")));
    }
    // In double precision, and once more where they are placed.
    budget.take(
        "vertices",
        element.count,
        size_of::<DVec3>() + size_of::<glam::Vec3>(),
    )?;
    // No more than the bytes that are there, which has been checked.
    let mut positions = Vec::with_capacity(element.count as usize);
    for _ in 0..element.count {
        let mut position = DVec3::ZERO;
        for (property, axis) in element.properties.iter().zip(&axes) {
            match axis {
                Some(axis) => position[*axis] = body.number(property.item)?,
                None => skip_property(property, body)?,
            }
        }
        positions.push(position);
    }
    Ok(positions)
}

/// Polygons, or strips of triangles, whose corners are not checked yet.
#[derive(Debug, Default)]
struct Faces {
    corners: Vec<u32>,
    /// Where the corners of each face end.
    ends: Vec<usize>,
    /// The faces are strips.
    are_strips: bool,
    slivers: u64,
}

impl Faces {
    fn read(
        element: &Element,
        body: &mut Body<'_>,
        budget: &mut Budget,
    ) -> Result<Self, LoadError> {
        let mut faces = Self::default();
        lists(element, body, |count, list| {
            faces.slivers += u64::from(count < 3);
            budget.take("faces", count, size_of::<u32>())?;
            budget.take("faces", 1, size_of::<usize>())?;
            for _ in 0..count {
                let corner = list.corner()?;
                faces.corners.push(index(corner)?);
            }
            faces.ends.push(faces.corners.len());
            Ok(())
        })?;
        Ok(faces)
    }

    fn read_strips(
        element: &Element,
        body: &mut Body<'_>,
        budget: &mut Budget,
    ) -> Result<Self, LoadError> {
        let mut faces = Self {
            are_strips: true,
            ..Self::default()
        };
        lists(element, body, |count, list| {
            budget.take("strips", count, size_of::<u32>() + size_of::<usize>())?;
            for _ in 0..count {
                match list.corner()? {
                    -1 => faces.ends.push(faces.corners.len()),
                    corner => faces.corners.push(index(corner)?),
                }
            }
            faces.ends.push(faces.corners.len());
            Ok(())
        })?;
        Ok(faces)
    }

    fn triangles(
        self,
        positions: &[DVec3],
        notes: &mut Notes,
        budget: &mut Budget,
    ) -> Result<Vec<[u32; 3]>, LoadError> {
        for &corner in &self.corners {
            if corner as usize >= positions.len() {
                return Err(LoadError::Scene(SceneError::IndexOutOfRange {
                    owner: "a PLY face".into(),
                    what: "vertex",
                    index: u64::from(corner),
                    count: positions.len() as u64,
                }));
            }
        }
        let faces = || {
            let starts = std::iter::once(0).chain(self.ends.iter().copied());
            let ranges = starts.zip(&self.ends);
            ranges.map(|(start, end)| &self.corners[start..*end])
        };
        let count: u64 = faces().map(|f| f.len().saturating_sub(2) as u64).sum();
        if count > MAX_TRIANGLES {
            return Err(LoadError::Scene(SceneError::TooManyTriangles {
                triangles: count,
                limit: MAX_TRIANGLES,
            }));
        }
        budget.take("triangles", count, size_of::<[u32; 3]>())?;
        let mut triangles = Vec::with_capacity(count as usize);
        if self.are_strips {
            for strip in faces() {
                let turned = |(i, w): (usize, &[u32])| match i % 2 {
                    0 => [w[0], w[1], w[2]],
                    _ => [w[0], w[2], w[1]],
                };
                triangles.extend(strip.windows(3).enumerate().map(turned));
            }
            return Ok(triangles);
        }
        let mut splitter = Splitter::default();
        for corners in faces() {
            splitter.split(corners, positions, &mut triangles);
        }
        let polygons = faces().filter(|corners| corners.len() > 3).count();
        if polygons > 0 {
            notes.add(format!(
                "{polygons} faces of more than three corners were split into triangles, {} of \
                 them concave",
                splitter.concave
            ));
        }
        if splitter.given_up > 0 {
            notes.add(format!(
                "{} concave faces were split into fans: they have too many corners",
                splitter.given_up
            ));
        }
        if self.slivers > 0 {
            notes.add(format!(
                "{} faces of less than three corners ignored",
                self.slivers
            ));
        }
        Ok(triangles)
    }
}

/// A list of vertex indices that is being read.
struct List<'a, 'b> {
    body: &'a mut Body<'b>,
    item: header::Scalar,
}

impl List<'_, '_> {
    fn corner(&mut self) -> Result<i64, LoadError> {
        self.body.integer(self.item)
    }
}

fn index(corner: i64) -> Result<u32, LoadError> {
    u32::try_from(corner)
        .map_err(|_| LoadError::bad_value("a vertex index of a PLY face", corner, "0 to 2^32 - 1"))
}

/// Calls `read` with the length of the list of vertex indices in each row; it
/// takes as many corners out of it.
fn lists(
    element: &Element,
    body: &mut Body<'_>,
    mut read: impl FnMut(u64, &mut List<'_, '_>) -> Result<(), LoadError>,
) -> Result<(), LoadError> {
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
    for _ in 0..element.count {
        for property in &element.properties {
            let Some(length) = property.list.filter(|_| is_corners(property)) else {
                skip_property(property, body)?;
                continue;
            };
            let count = body.list_length(length, property.item)?;
            let item = property.item;
            read(count, &mut List { body, item })?;
        }
    }
    Ok(())
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
    let names: Vec<String> = properties.iter().map(|p| printable(&p.name)).collect();
    format!("[{}]", names.join(", "))
}
