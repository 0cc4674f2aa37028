//! Embedded scenes made ready for suites and benches.

use gpu_backend::Cpu;
use lighting::procedural::Embedded;
use lighting::scene::{Geometry, Medium, Scene};
use lighting::trace::Tracer;
use lighting::view::View;
use lighting::{Emitter, Ray};

/// A scene, its emitters and the rays of its view.
#[derive(Debug)]
pub struct Stage {
    /// The embedded scene's name.
    pub name: &'static str,
    /// The checked triangles.
    pub geometry: Geometry,
    /// The triangles in their hierarchy.
    pub tracer: Tracer,
    /// All lights.
    pub emitters: Vec<Emitter>,
    /// What fills the air.
    pub medium: Medium,
    /// One per pixel.
    pub rays: Vec<Ray>,
}

impl Stage {
    /// Builds `embedded` with seed 1, seen in `width` × `height` pixels; an
    /// area light becomes about four points.
    ///
    /// # Panics
    /// If the scene is not sound, which its own tests exclude.
    pub fn new(embedded: Embedded, width: u32, height: u32) -> Self {
        let mut scene: Scene = embedded.build(1);
        let geometry = Geometry::new(&scene).expect("a sound scene");
        scene
            .complete(geometry.bounds())
            .expect("a camera and a light");
        scene.fill_with_fog(geometry.bounds()).expect("a medium");
        let tracer = Tracer::new(&geometry);
        let camera = scene.camera.expect("a camera was placed");
        let view = View::new(&Cpu::new(), &camera, &tracer, width, height).expect("a legal size");
        let emitters = scene
            .lights
            .iter()
            .flat_map(|light| light.emitters(4).expect("a sound light"))
            .collect();
        Self {
            name: embedded.name(),
            tracer,
            emitters,
            medium: scene.medium.expect("a medium was placed"),
            rays: view.rays().to_vec(),
            geometry,
        }
    }
}
