//! glTF files written here, good and bad.

mod bad;
mod compressed;
mod draco;
mod extensions;
mod geometry;
mod lights;
mod materials;
mod posed;
mod surfaces;

use glam::Vec3;

use crate::load::{LoadError, LoadOptions, Loaded, OpenFile};
use crate::{Geometry, Scene};

/// A document in the making: one buffer, its views and accessors.
#[derive(Default)]
struct Draft {
    binary: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Draft {
    /// Adds a buffer view and returns its index.
    fn view(&mut self, bytes: &[u8], more: &str) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.views.push(format!(
            r#"{{"buffer":0,"byteOffset":{},"byteLength":{}{more}}}"#,
            self.binary.len(),
            bytes.len()
        ));
        self.binary.extend(bytes);
        self.views.len() - 1
    }

    /// Adds an accessor over a view of its own and returns its index.
    fn accessor(&mut self, bytes: &[u8], component: u32, shape: &str, count: usize) -> usize {
        let view = self.view(bytes, "");
        self.accessors.push(format!(
            r#"{{"bufferView":{view},"componentType":{component},"type":"{shape}","count":{count}}}"#
        ));
        self.accessors.len() - 1
    }

    fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        self.accessor(
            bytemuck::cast_slice(positions),
            5126,
            "VEC3",
            positions.len(),
        )
    }

    fn coordinates(&mut self, coordinates: &[[f32; 2]]) -> usize {
        self.accessor(
            bytemuck::cast_slice(coordinates),
            5126,
            "VEC2",
            coordinates.len(),
        )
    }

    fn indices(&mut self, indices: &[u16]) -> usize {
        self.accessor(bytemuck::cast_slice(indices), 5123, "SCALAR", indices.len())
    }

    /// The document with `rest` added to its top level.
    fn json(&self, uri: Option<&str>, rest: &str) -> String {
        let uri = uri.map_or(String::new(), |uri| format!(r#","uri":"{uri}""#));
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}{uri}}}],"bufferViews":[{}],"accessors":[{}],{rest}}}"#,
            self.binary.len(),
            self.views.join(","),
            self.accessors.join(",")
        )
    }

    fn glb(&self, rest: &str) -> Vec<u8> {
        let mut json = self.json(None, rest).into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        let mut file = b"glTF\x02\0\0\0".to_vec();
        file.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
            file.extend((chunk.len() as u32).to_le_bytes());
            file.extend(kind);
            file.extend(chunk);
        }
        file
    }

    fn load(&self, rest: &str) -> Result<Loaded, LoadError> {
        load(&self.glb(rest))
    }
}

/// Loads a document, strictly.
fn gltf_from_slice(bytes: &[u8], open: OpenFile<'_>) -> Result<Loaded, LoadError> {
    super::gltf_from_slice(bytes, &LoadOptions::default(), open)
}

/// Loads a document that refers to no files, leaving out what cannot be read.
fn load_leniently(bytes: &[u8]) -> Result<Loaded, LoadError> {
    let options = LoadOptions {
        lenient: true,
        ..LoadOptions::default()
    };
    super::gltf_from_slice(bytes, &options, &mut |path| {
        panic!("{path} should not be opened")
    })
}

/// Loads a document that refers to no files.
fn load(bytes: &[u8]) -> Result<Loaded, LoadError> {
    gltf_from_slice(bytes, &mut |path| panic!("{path} should not be opened"))
}

const TETRAHEDRON: [[f32; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const FACES: [u16; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];

/// A tetrahedron of volume 1/6 as mesh 0.
fn tetrahedron() -> (Draft, String) {
    let mut draft = Draft::default();
    let (positions, indices) = (draft.positions(&TETRAHEDRON), draft.indices(&FACES));
    let mesh = format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{positions}}},"indices":{indices}}}]}}]"#
    );
    (draft, mesh)
}

/// A square of side 2 in the plane z = 0 that faces +Z, texture upright, as
/// mesh 0 with material 0.
fn square() -> (Draft, String) {
    let mut draft = Draft::default();
    let positions = draft.positions(&[
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
    ]);
    let coordinates = draft.coordinates(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]]);
    let indices = draft.indices(&[0, 1, 2, 2, 3, 0]);
    let mesh = format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{positions},"TEXCOORD_0":{coordinates}}},"indices":{indices},"material":0}}]}}],"nodes":[{{"mesh":0}}]"#
    );
    (draft, mesh)
}

/// The enclosed volume, positive if the triangles face outwards.
fn volume(scene: &Scene) -> f32 {
    let geometry = Geometry::new(scene).unwrap();
    let corner = |[a, b, c]: &[Vec3; 3]| a.dot(b.cross(*c));
    geometry.triangles().iter().map(corner).sum::<f32>() / 6.0
}
