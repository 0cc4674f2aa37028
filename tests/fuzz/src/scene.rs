//! Scene files of every format, through to a tiny picture.

use glam::Vec3;
use gpu_backend::Cpu;
use lighting::methods::Entry;
use lighting::scene::load::{
    LoadError, LoadOptions, Loaded, UpAxis, gltf_from_slice, hair_from_slice, nvdb_from_slice,
    obj_from_slice, ply_from_slice, vdb_from_slice, vol_colours_from_slice, vol_from_slice,
};
use lighting::scene::trace::Tracer;
use lighting::scene::view::View;
use lighting::scene::{Emitter, Geometry, Medium, Mesh, Scene, Translucent};

use super::frame::{METHODS, Tiny, least};

mod files;

/// Between a file and the others that it refers to.
const OTHER: &[u8] = b"\n--file--\n";

/// Scenes with more than this load, and are not rendered.
const MOST: usize = 4096;

/// The two bytes in front of a file: its format, and how it is read. Lengths in binary glTF
/// files are mended, unless `how` says not to: they would keep most changes from being read.
fn load(format: u8, how: u8, file: &[u8]) -> Result<Loaded, LoadError> {
    let is_gltf = format.is_multiple_of(7);
    let options = LoadOptions {
        lenient: how & 1 == 1,
        assets: None,
        unit: if how & 2 == 2 && !is_gltf { 0.01 } else { 1.0 },
        up: match how >> 2 & 3 {
            1 if !is_gltf => UpAxis::X,
            2 if !is_gltf => UpAxis::Z,
            _ => UpAxis::Y,
        },
    };
    let mut others = Vec::new();
    let mut file = file;
    while let Some(at) = file
        .windows(OTHER.len())
        .rposition(|window| window == OTHER)
    {
        others.insert(0, &file[at + OTHER.len()..]);
        file = &file[..at];
    }
    // File 2 is the one that is called "2.png", and so on.
    let mended;
    if is_gltf && how & 16 == 0 {
        mended = files::with_lengths(file);
        file = &mended;
    }
    let mut open = |name: &str| {
        let number = name.bytes().find(u8::is_ascii_digit).unwrap_or(b'1');
        let other = others.get(usize::from(number.saturating_sub(b'1')));
        Ok(other.map_or_else(Vec::new, |other| other.to_vec()))
    };
    match format % 7 {
        0 => gltf_from_slice(file, &options, &mut open),
        1 => obj_from_slice(file, &options, &mut open),
        2 => ply_from_slice(file, &options),
        3 => hair_from_slice(file, &options),
        4 => {
            drop(vol_colours_from_slice(file, &options));
            vol_from_slice(file, &options)
        }
        5 => nvdb_from_slice(file, &options),
        _ => vdb_from_slice(file, &options),
    }
}

/// The scene with a triangle at least, on which what is of smoke or hair alone stands.
fn on_the_ground(scene: Scene) -> Scene {
    if !scene.meshes.is_empty() {
        return scene;
    }
    let ground = Scene::from(Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Z],
        triangles: vec![[0, 1, 2]],
        ..Mesh::default()
    });
    Scene {
        meshes: ground.meshes,
        instances: ground.instances,
        ..scene
    }
}

/// How much there is to go through of smoke and hair.
fn parts(scene: &Scene) -> usize {
    let parts = |translucent: &Translucent| match translucent {
        Translucent::Grid(grid) => grid.density().len() / 64,
        Translucent::Strands(strands) => strands.points().len(),
        _ => 0,
    };
    scene.translucent.iter().map(parts).sum()
}

/// Whether nothing in a scene is so bright, so dense or so near to its limits that light
/// itself leaves the range of f32.
fn is_tame(emitters: &[Emitter], medium: &Medium) -> bool {
    let is_tame = |light: &Emitter| light.intensity().max_element() < 1e9;
    emitters.iter().all(is_tame) && medium.sigma_s().max_element() < 1e9
}

/// A picture by a method, of two lights that follow each other in the scene.
fn render(scene: Scene, method: &Entry, first_light: u8) {
    let mut scene = on_the_ground(scene);
    let Ok(geometry) = Geometry::new(&scene) else {
        return;
    };
    if geometry.triangles().len() > MOST || parts(&scene) > MOST {
        return;
    }
    // What is missing cannot always be placed: of a scene of 1e9 m, for one.
    if scene.complete(geometry.bounds()).is_err() || scene.fill_with_fog(geometry.bounds()).is_err()
    {
        return;
    }
    let Some(camera) = scene.camera else { return };
    let tracer = Tracer::new(&geometry);
    let view = View::new(&Cpu::single_threaded(), &camera, &tracer, 3, 2).expect("a legal size");
    let lights = scene.lights.iter().cycle();
    let lights = lights
        .skip(first_light.into())
        .take(scene.lights.len().min(2));
    let emitters: Result<Vec<Vec<Emitter>>, _> = lights.map(|light| light.emitters(2)).collect();
    let Ok(emitters) = emitters else { return };
    let emitters = emitters.concat();
    let medium = scene.medium.unwrap_or(Medium::VACUUM);
    let tiny = Tiny {
        geometry: &geometry,
        camera: &camera,
        view: &view,
        medium: &medium,
        height_fog: scene.height_fog.as_ref(),
        translucent: &scene.translucent,
    };
    if let Ok(image) = tiny.image(&emitters, method, least(method)) {
        let is_sound =
            |value: &f32| *value >= 0.0 && (value.is_finite() || !is_tame(&emitters, &medium));
        assert!(image.iter().flatten().all(is_sound), "{image:?}");
    }
}

/// A file of any format gives an error or a scene, and a scene an error or a picture of
/// numbers that are not negative, by a method that the third byte chooses.
///
/// # Panics
/// If not.
pub fn run(data: &[u8]) {
    let [format, how, method, file @ ..] = data else {
        return;
    };
    let Ok(Loaded { scene, .. }) = load(*format, *how, file) else {
        return;
    };
    let methods = [
        "exact x quadrature",
        "march x midpoint",
        "translucent x midpoint",
        "voxel-runs x gauss-8",
    ];
    let name = methods[usize::from(*method) % methods.len()];
    let heterogeneous = scene.height_fog.is_some() || !scene.translucent.is_empty();
    let entry = match METHODS.for_heterogeneous_media() {
        Some(entry) if heterogeneous && method & 128 == 0 => entry.clone(),
        _ => METHODS.find(name).expect("a standard method"),
    };
    render(scene, &entry, method >> 2 & 3);
}

/// Small files of every format, for each method.
pub fn seeds() -> Vec<Vec<u8>> {
    let mut seeds = Vec::new();
    for (format, file) in files::all() {
        for method in [0, 1, 2 + 128, 3 + 128] {
            seeds.push([&[format, method & 1, method], file.as_slice()].concat());
        }
    }
    seeds
}
