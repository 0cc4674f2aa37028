//! Embedded scenes made ready for suites and benches.

use gpu_backend::Cpu;
use scene::procedural::Embedded;
use scene::trace::{Hit, Tracer};
use scene::view::View;
use scene::{AreaEmitters, Camera, Emitter, Geometry, HeightFog, Medium, Ray, Scene, Translucent};

use crate::oracle::airlight::reach;
use crate::oracle::image::{Options, Reference, reference};
use crate::oracle::media::Air;
use crate::oracle::{Fog, Lamp, Line, media_image};

/// A scene, its emitters and the rays of its view.
#[derive(Debug)]
pub struct TestScene {
    /// The embedded scene's name.
    pub name: &'static str,
    /// The checked triangles.
    pub geometry: Geometry,
    /// The triangles in their hierarchy.
    pub tracer: Tracer,
    /// All lights.
    pub emitters: Vec<Emitter>,
    /// Those among them that stand for area lights.
    pub areas: Vec<AreaEmitters>,
    /// What fills the air.
    pub medium: Medium,
    /// Where the rays start.
    pub camera: Camera,
    /// Width and height of the picture.
    pub size: [u32; 2],
    /// One per pixel.
    pub rays: Vec<Ray>,
    /// What each ray ends on.
    pub hits: Vec<Option<Hit>>,
    /// Hair and smoke.
    pub translucent: Vec<Translucent>,
    /// Fog that thins out with altitude.
    pub height_fog: Option<HeightFog>,
}

impl TestScene {
    /// Builds `embedded` with seed 1, seen in `width` × `height` pixels; an
    /// area light becomes about four points.
    ///
    /// # Panics
    /// If the scene is not sound, which its own tests exclude.
    pub fn new(embedded: Embedded, width: u32, height: u32) -> Self {
        Self::of(embedded.name(), embedded.build(1), width, height)
    }

    /// The same of any scene; what it lacks of camera, lights and medium is placed.
    ///
    /// # Panics
    /// If the scene is not sound.
    pub fn of(name: &'static str, mut scene: Scene, width: u32, height: u32) -> Self {
        let geometry = Geometry::new(&scene).expect("a sound scene");
        scene
            .complete(geometry.bounds())
            .expect("a camera and a light");
        scene.fill_with_fog(geometry.bounds()).expect("a medium");
        let tracer = Tracer::new(&geometry);
        let camera = scene.camera.expect("a camera was placed");
        let view = View::new(&Cpu::new(), &camera, &tracer, width, height).expect("a legal size");
        let (mut emitters, mut owners) = (Vec::new(), Vec::new());
        for (index, light) in scene.lights.iter().enumerate() {
            emitters.extend(light.emitters(4).expect("a sound light"));
            owners.resize(emitters.len(), index);
        }
        Self {
            name,
            tracer,
            emitters,
            areas: AreaEmitters::find(&scene.lights, &owners),
            medium: scene.medium.unwrap_or(Medium::VACUUM),
            camera,
            size: [width, height],
            rays: view.rays().to_vec(),
            hits: view.hits().to_vec(),
            translucent: scene.translucent,
            height_fog: scene.height_fog,
            geometry,
        }
    }

    /// An embedded scene as far as `coarsest` steps along a ray resolve it.
    ///
    /// An order of convergence is what errors do in the end, when steps are finer
    /// than what they sample. So rays are left out that pass a light closer than
    /// one of the coarsest steps, unless all do.
    pub fn resolvable(embedded: Embedded, width: u32, height: u32, coarsest: u32) -> Self {
        let mut test_scene = Self::new(embedded, width, height);
        let bounds = test_scene.geometry.bounds();
        let size = bounds.min().distance(bounds.max());
        let fog = Fog::new(&test_scene.medium);
        let lamps: Vec<Lamp> = test_scene.emitters.iter().map(Lamp::new).collect();
        let far_enough = |ray: &Ray| {
            let line = Line::new(ray);
            lamps.iter().all(|lamp| {
                let Lamp::Point(bulb) = lamp else { return true };
                reach(&line, lamp, &fog).is_none_or(|span| {
                    let h = line.nearest(bulb.position).1.length();
                    let way = (span.end - span.start).min(10.0 * f64::from(size));
                    h * f64::from(coarsest) > way
                })
            })
        };
        let all = test_scene.rays.iter().zip(&test_scene.hits);
        let (rays, hits): (Vec<Ray>, Vec<Option<Hit>>) =
            all.filter(|(ray, _)| far_enough(ray)).unzip();
        if !rays.is_empty() {
            (test_scene.rays, test_scene.hits) = (rays, hits);
        }
        test_scene
    }

    /// The reference image of the rays where smoke and fog that thins out are seen, to 1e-3.
    pub fn truth_in_media(&self) -> Reference {
        let air = Air {
            medium: Some(&self.medium),
            height_fog: self.height_fog.as_ref(),
            translucent: &self.translucent,
        };
        let options = Options {
            tolerance: 1e-3,
            ..Options::default()
        };
        media_image::reference(&self.rays, air, &self.emitters, &self.geometry, options)
    }

    /// The reference image of the rays in even fog.
    pub fn truth(&self) -> Reference {
        reference(
            &self.rays,
            &self.emitters,
            &self.medium,
            &self.geometry,
            Options::default(),
        )
    }
}
