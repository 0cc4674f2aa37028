//! PLY files written here, good and bad.

use glam::Vec3;

use super::*;
use crate::Geometry;

/// A tetrahedron, ASCII.
const ASCII: &str = "ply\r
format ascii 1.0\r
comment the windows kind of line end\r
element vertex 4\r
property double y\r
property float nx\r
property short x\r
property list uchar int rings\r
property float z\r
element nothing 4000000000\r
element edge 1\r
property int a\r
property list uint8 float weights\r
element face 4\r
property uchar flags\r
property list uchar uint vertex_index\r
property list ushort double areas\r
end_header\r
0 9 0 0 0 0 9 1 2 8 8 0
1.0 9 0 0 0e0 0 9 0 1 7 1
3 2 0.5 0.25
0 3 0 2 1 0
0 3 0 1 3 1 0.5
0 3 0 3 2 0
0 3 1 2 3 2 1 1";

fn read(bytes: &[u8]) -> Result<Loaded, LoadError> {
    ply_from_slice(bytes, &LoadOptions::default())
}

struct Binary {
    bytes: Vec<u8>,
    big: bool,
}

impl Binary {
    fn push<const N: usize>(&mut self, little: [u8; N]) {
        if self.big {
            self.bytes.extend(little.iter().rev());
        } else {
            self.bytes.extend(little);
        }
    }
}

/// A pyramid with a square base, binary.
fn pyramid(big: bool) -> Vec<u8> {
    let endian = if big { "big" } else { "little" };
    let header = format!(
        "ply\nformat binary_{endian}_endian 1.0\nobj_info \nelement face 5\n\
         property list ushort int16 vertex_indices\nproperty float32 quality\n\
         element vertex 5\nproperty float z\nproperty int8 tag\nproperty float64 x\n\
         property uint16 y\nelement rest 7\nproperty int unread\nend_header\n"
    );
    let mut file = Binary {
        bytes: header.into_bytes(),
        big,
    };
    let faces: [&[i16]; 5] = [
        &[0, 3, 2, 1],
        &[0, 1, 4],
        &[1, 2, 4],
        &[2, 3, 4],
        &[3, 0, 4],
    ];
    for face in faces {
        file.push((face.len() as u16).to_le_bytes());
        for corner in face {
            file.push(corner.to_le_bytes());
        }
        file.push(0.5_f32.to_le_bytes());
    }
    for [x, y, z] in [[-1, 0, 1], [1, 0, 1], [1, 0, -1], [-1, 0, -1], [0, 258, 0]] {
        file.push((z as f32).to_le_bytes());
        file.push((-1_i8).to_le_bytes());
        file.push(f64::from(x).to_le_bytes());
        file.push((y as u16).to_le_bytes());
    }
    file.bytes.extend([0; 28]);
    file.bytes
}

/// The enclosed volume, positive if the triangles face outwards.
fn volume(scene: &Scene) -> f32 {
    let geometry = Geometry::new(scene).unwrap();
    let triangles = geometry.triangles().iter();
    triangles.map(|[a, b, c]| a.dot(b.cross(*c))).sum::<f32>() / 6.0
}

#[test]
fn ascii_columns_are_found_in_any_order() {
    let loaded = read(ASCII.as_bytes()).unwrap();
    let mesh = &loaded.scene.meshes[0];
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]);
    assert_eq!(mesh.triangles[3], [1, 2, 3]);
    assert!((volume(&loaded.scene) - 1.0 / 6.0).abs() < 1e-6);
    assert_eq!(loaded.notes, ["vertex properties ignored: nx, rings"]);
}

#[test]
fn binary_of_either_byte_order_reads_alike() {
    for big in [false, true] {
        let loaded = read(&pyramid(big)).unwrap();
        let mesh = &loaded.scene.meshes[0];
        assert_eq!(mesh.positions[4], Vec3::Y * 258.0);
        assert_eq!(mesh.positions[3], Vec3::new(-1.0, 0.0, -1.0));
        assert_eq!(mesh.triangles[..2], [[0, 3, 2], [0, 2, 1]]);
        assert_eq!(mesh.triangles.len(), 6);
        assert!((volume(&loaded.scene) - 4.0 * 258.0 / 3.0).abs() < 1e-2);
        let notes = loaded.notes;
        assert!(notes[1].starts_with("1 faces of more"), "{notes:?}");
    }
}

fn ascii(vertices: &str, faces: &str, body: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\n\
         end_header\n{body}"
    )
}

#[test]
fn bad_files_are_refused_with_their_cause() {
    let corners = "0 0 0 1 0 0 0 1 0 ";
    let cases = [
        (String::new(), "header"),
        ("ply\n".into(), "end_header"),
        ("pla\n".into(), "\"ply\""),
        ("ply\nformat ascii 2.0\nend_header\n".into(), "version 2.0 of line 2"),
        ("ply\nformat morse 1.0\nend_header\n".into(), "line 2 of the PLY header is 16 other characters"),
        ("ply\nend_header\n".into(), "format line"),
        ("ply\nproperty int x\n".into(), "element line before"),
        ("ply\nelement vertex -1\n".into(), "line 2"),
        ("ply\nelement vertex 99999999999999999999\n".into(), "2^64"),
        ("ply\nelement a 1\nelement a 1\n".into(), "with each name once"),
        ("ply\nelement a 1\nproperty half x\n".into(), "line 3"),
        ("ply\nelement a 1\nproperty list float int x\n".into(), "length is an integer"),
        ("ply\nelement a 1\nproperty int\n".into(), "property TYPE NAME"),
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nend_header\n1".into(), "[x]"),
        (
            "ply\nformat ascii 1.0\nelement face 1\nproperty list int float vertex_index\nend_header\n1 1".into(),
            "list of integers",
        ),
        (ascii("4000000000", "1", corners), "4000000000 rows"),
        (ascii("18446744073709551615", "1", corners), "18446744073709551615 rows"),
        (ascii("3", "4000000000", corners), "4000000000 rows"),
        (ascii("3", "1", &format!("{corners} 3 0 1")), "3 items needs 5 bytes"),
        (ascii("3", "1", &format!("{corners} 4000000000 0 1")), "4000000000 items"),
        (ascii("3", "1", &format!("{corners} -3 0 1 2")), "-3"),
        (ascii("3", "1", &format!("{corners} 3 0 1 3")), "vertex index 3"),
        (ascii("3", "1", &format!("{corners} 3 0 1 -2")), "-2"),
        (ascii("3", "1", &format!("{corners} 3 0 1 1.5")), "1.5"),
        (ascii("3", "1", "0 0 0 1 0 zero 0 1 0 3 0 1 2"), "4 other characters"),
        (ascii("3", "0", corners), "no triangles"),
        (ascii("3", "1", &format!("{corners} 2 0 1")), "no triangles"),
    ];
    for (file, cause) in cases {
        let error = read(file.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(cause), "{file}\n{error}");
    }
}

/// A strip that stands alone in its file.
fn strips(list: &[i32]) -> Vec<u8> {
    let mut file = b"ply\nformat binary_little_endian 1.0\nelement vertex 5\n\
        property float x\nproperty float y\nproperty float z\nelement tristrips 1\n\
        property list int int vertex_indices\nend_header\n"
        .to_vec();
    for corner in [
        [0.0, 0.0],
        [1.0, 0.0],
        [0.0, 1.0],
        [1.0, 1.0],
        [0.0, 2.0_f32],
    ] {
        for number in [corner[0], corner[1], 0.0] {
            file.extend(number.to_le_bytes());
        }
    }
    for number in std::iter::once(list.len() as i32).chain(list.iter().copied()) {
        file.extend(number.to_le_bytes());
    }
    file
}

#[test]
fn strips_restart_at_minus_one_and_keep_their_front() {
    for (list, expected) in [
        (&[0, 1, 2, 3, 4][..], &[[0, 1, 2], [1, 3, 2], [2, 3, 4]][..]),
        (&[0, 1, 2, -1, 1, 3, 2], &[[0, 1, 2], [1, 3, 2]]),
        (&[-1, -1, 0, 1, -1, 0, 1, 2, -1], &[[0, 1, 2]]),
    ] {
        let loaded = read(&strips(list)).unwrap();
        assert_eq!(loaded.scene.meshes[0].triangles, expected);
        let geometry = Geometry::new(&loaded.scene).unwrap();
        for [a, b, c] in geometry.triangles() {
            assert!((*b - *a).cross(*c - *a).z > 0.0);
        }
    }
    for list in [&[0, 1, -2][..], &[0, 1, 9], &[0, 1, -1]] {
        assert!(read(&strips(list)).is_err());
    }
    let file = strips(&[0, 1, 2, -1, 1, 3, 2]);
    for length in 0..file.len() {
        assert!(read(&file[..length]).is_err(), "{length}");
    }
}

#[test]
fn concave_faces_are_covered_once_whichever_corner_they_start_at() {
    let corners = "0 0 0 0 0 3 1 0 3 1 0 1 3 0 1 3 0 0";
    for start in 0..6 {
        let list: Vec<String> = (0..6).map(|i| ((start + i) % 6).to_string()).collect();
        let file = ascii("6", "1", &format!("{corners} 6 {}", list.join(" ")));
        let loaded = read(file.as_bytes()).unwrap();
        let geometry = Geometry::new(&loaded.scene).unwrap();
        let area = |[a, b, c]: &[Vec3; 3]| 0.5 * (*b - *a).cross(*c - *a).length();
        let area: f32 = geometry.triangles().iter().map(area).sum();
        assert!((area - 5.0).abs() < 1e-5, "{start}: {area}");
        assert!(loaded.notes[0].contains("1 of them concave"));
    }
}

#[test]
fn lines_may_end_in_carriage_returns_alone() {
    let file = ascii("3", "1", "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").replace('\n', "\r");
    let loaded = read(file.as_bytes()).unwrap();
    assert_eq!(loaded.scene.meshes[0].triangles, [[0, 1, 2]]);
}

#[test]
fn double_coordinates_far_away_keep_their_differences() {
    let file = ascii(
        "3",
        "1",
        "4649776.125 0.1 500000.2 4649776.225 0.1 500000.2 4649776.125 0.2 500000.2 3 0 1 2",
    );
    let file = file.replace("float", "double");
    let loaded = read(file.as_bytes()).unwrap();
    let positions = &loaded.scene.meshes[0].positions;
    assert!((positions[1] - positions[0] - 0.1 * Vec3::X).length() < 1e-6);
    assert!((positions[2] - positions[0] - 0.1 * Vec3::Y).length() < 1e-6);
    let back = loaded.offset + positions[0].as_dvec3();
    assert!((back - DVec3::new(4_649_776.125, 0.1, 500_000.2)).length() < 1e-6);
    assert!(loaded.notes[0].contains("moved by"), "{:?}", loaded.notes);
}

#[test]
fn unit_and_up_axis_apply() {
    let options = LoadOptions {
        unit: 0.001,
        up: crate::load::UpAxis::Z,
        ..LoadOptions::default()
    };
    let file = ascii("3", "1", "1 2 3 1 0 0 0 1 0 3 0 1 2");
    let loaded = ply_from_slice(file.as_bytes(), &options).unwrap();
    let first = loaded.scene.meshes[0].positions[0];
    assert!((first - Vec3::new(0.001, 0.003, -0.002)).length() < 1e-9);
}

#[test]
fn errors_repeat_nothing_of_the_file() {
    for file in [
        "root:secret\n".to_owned(),
        "ply\nformat secret 1.0\n".into(),
        "ply\nformat ascii secret\n".into(),
        "ply\nsecret\n".into(),
        "ply\nelement a secret\n".into(),
        "ply\nelement a 1\nproperty secret x\n".into(),
        ascii("3", "1", "0 0 secret"),
        ascii("3", "1", "0 0 0 1 0 0 0 1 0 3 0 1 secret"),
        ascii("3", "1", "0 0 0 1 0 0 0 1 0 secret"),
    ] {
        let error = read(file.as_bytes()).unwrap_err().to_string();
        assert!(!error.contains("secret"), "{error}");
    }
}

#[test]
fn positions_that_are_not_finite_are_left_to_the_geometry() {
    let file = ascii("3", "1", "0 0 0 1 nan 0 0 1 1e300 3 0 1 2");
    let loaded = read(file.as_bytes()).unwrap();
    let error = Geometry::new(&loaded.scene).unwrap_err().to_string();
    assert!(error.contains("vertex 1"), "{error}");
}

#[test]
fn every_truncation_is_an_error() {
    for big in [false, true] {
        let file = pyramid(big);
        // The element after the last face is not needed.
        for length in 0..file.len() - 28 {
            assert!(read(&file[..length]).is_err(), "{length}");
        }
    }
}

#[test]
fn damage_never_panics() {
    let concave = ascii(
        "6",
        "1",
        "0 0 0 0 0 3 1 0 3 1 0 1 3 0 1 3 0 0 6 0 1 2 3 4 5",
    );
    let files = [
        ASCII.as_bytes().to_vec(),
        pyramid(false),
        pyramid(true),
        strips(&[0, 1, 2, -1, 1, 3, 2]),
        concave.into_bytes(),
    ];
    for file in files {
        crate::load::damage::survives(&file, |damaged| drop(read(damaged)));
    }
}
