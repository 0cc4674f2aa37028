//! The ways of cameras and lights through a film.

use glam::{Quat, Vec3};
use lighting::scene::trace::Tracer;
use lighting::scene::{Camera, Light, SceneError};
use reference::random::Random;

use crate::args::FilmPath;
use crate::compare::measure::Job;
use crate::compare::study::LeftOut;
use crate::parse::Size;

/// Steps of the camera, in pixels at the mean distance of what is seen.
const PIXELS: f32 = 1.0 / 3.0;

/// Steps of lights, in texels of a shadow map that spans a right angle.
const TEXELS: f32 = 0.5;

/// The longest large step: as a share of the mean distance to what is seen or lit, and in
/// radians.
const FAR: f32 = 0.1;
const TURN: f32 = 0.1;

/// Seed of the places of large steps.
const SEED: u64 = 21;

/// How often a place that nothing hides is looked for, each time nearer than the last.
const TRIES: u32 = 16;

/// The things that move in a shot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Moved {
    Camera,
    Lights,
}

/// How far they move from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Steps {
    /// By less than methods resolve, forth and back through the same places; it turns back at
    /// half the number of frames.
    Small,
    /// To any place nearby, which has nothing to do with the last one.
    Large,
}

/// How the camera or the lights of a frame have moved from their places in the scene.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Pose {
    /// Metres.
    pub(super) shift: Vec3,
    /// To the left and up, radians, of the camera or of lights that have no place.
    pub(super) turn: [f32; 2],
}

/// Frames that follow each other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shot {
    pub(super) moved: Moved,
    pub(super) steps: Steps,
    /// The length of a step, m; of large ones the largest distance from the middle. None if
    /// nothing that moves has a place.
    pub(super) length: Option<f32>,
    /// The angle by which lights without a place turn, rad. In large steps everything turns, by
    /// this angle at most.
    pub(super) angle: f32,
    pub(super) poses: Vec<Pose>,
}

impl Moved {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Lights => "lights",
        }
    }
}

impl Steps {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Small => "small",
            Self::Large => "large",
        }
    }
}

impl Shot {
    /// What moves how, in a few words.
    pub(super) fn name(&self) -> String {
        let steps = match (self.moved, self.steps) {
            (Moved::Camera, Steps::Small) => "a third of a pixel from frame to frame",
            (Moved::Lights, Steps::Small) => "half a texel from frame to frame",
            (_, Steps::Large) => "frames far apart",
        };
        format!("{}: {steps}", self.moved.name())
    }
}

impl Pose {
    pub(super) fn of_camera(&self, camera: &Camera) -> Result<Camera, SceneError> {
        let [left, up] = self.turn;
        let rotation = Quat::from_rotation_y(left) * camera.rotation() * Quat::from_rotation_x(up);
        // A direction that is not turned keeps its bits.
        let rotation = match self.turn {
            [0.0, 0.0] => camera.rotation(),
            _ => rotation,
        };
        Camera::new(camera.eye() + self.shift, rotation, camera.vertical_fov())
    }

    pub(super) fn of_light(&self, light: &Light) -> Light {
        let mut light = light.clone();
        match &mut light {
            Light::Point(point) => point.position += self.shift,
            Light::Spot(spot) => spot.position += self.shift,
            Light::Area(area) => area.corner += self.shift,
            Light::Directional(sun) => {
                let [left, up] = self.turn;
                let along = sun.direction.normalize();
                let (side, other) = along.any_orthonormal_pair();
                let turn = Quat::from_axis_angle(side, up) * Quat::from_axis_angle(other, left);
                sun.direction = turn * sun.direction;
            }
            _ => {}
        }
        light
    }
}

/// How many shots a film has.
pub(super) fn shot_count(path: FilmPath) -> usize {
    2 * moved(path).len()
}

fn moved(path: FilmPath) -> &'static [Moved] {
    match path {
        FilmPath::Camera => &[Moved::Camera],
        FilmPath::Light => &[Moved::Lights],
        FilmPath::Both => &[Moved::Camera, Moved::Lights],
    }
}

/// The shots of a film, or why one of them cannot be made.
pub(super) fn shots(
    path: FilmPath,
    frames: usize,
    job: &Job<'_>,
    size: Size,
) -> Vec<Result<Shot, LeftOut>> {
    let mut shots = Vec::new();
    for &moved in moved(path) {
        let space = match moved {
            Moved::Camera => Space::of_camera(job, size),
            Moved::Lights => Space::of_lights(job),
        };
        for steps in [Steps::Small, Steps::Large] {
            let mut shot = Shot {
                moved,
                steps,
                length: Some(space.step),
                angle: space.angle,
                poses: Vec::new(),
            };
            match steps {
                Steps::Small => shot.poses = space.forth_and_back(frames),
                Steps::Large => {
                    shot.length = Some(space.far);
                    shot.angle = TURN;
                    shot.poses = space.far_apart(frames);
                }
            }
            shot.length = shot.length.filter(|_| !space.places.is_empty());
            shots.push(match shot.poses.is_empty() {
                true => Err(LeftOut {
                    what: shot.name(),
                    why: "there is no room to move".into(),
                }),
                false => Ok(shot),
            });
        }
    }
    shots
}

/// The space in which the camera or the lights can move.
struct Space<'a> {
    tracer: &'a Tracer,
    /// The places of the camera or the lights in the scene.
    places: Vec<Vec3>,
    /// Directions of small steps. The one with room for most steps is taken, and the first of
    /// several.
    directions: [Vec3; 4],
    /// The length of a small step, m.
    step: f32,
    /// The angle of a small step of lights that have no place, rad.
    angle: f32,
    /// How far large steps go, m.
    far: f32,
}

impl<'a> Space<'a> {
    fn of_camera(job: &Job<'a>, size: Size) -> Self {
        let camera = job.camera;
        let distance = mean_distance(job, &[camera.eye()]);
        let pixel = 2.0 * (0.5 * camera.vertical_fov()).tan() / size.height as f32 * distance;
        let [right, up] = [Vec3::X, Vec3::Y].map(|axis| camera.rotation() * axis);
        // The directions run along neither rows nor columns of pixels.
        let directions = [[0.8, 0.6], [-0.8, 0.6], [0.8, -0.6], [-0.8, -0.6]];
        Self {
            tracer: &job.input.tracer,
            places: vec![camera.eye()],
            directions: directions.map(|[x, y]| x * right + y * up),
            step: PIXELS * pixel,
            angle: 0.0,
            far: FAR * distance,
        }
    }

    fn of_lights(job: &Job<'a>) -> Self {
        let place = |light: &Light| match light {
            Light::Point(point) => Some(point.position),
            Light::Spot(spot) => Some(spot.position),
            Light::Area(area) => Some(area.corner + 0.5 * (area.edges[0] + area.edges[1])),
            _ => None,
        };
        let places: Vec<Vec3> = job.input.scene.lights.iter().filter_map(place).collect();
        let distance = mean_distance(job, &places);
        let angle = TEXELS * 2.0 / job.map as f32;
        let directions = [[0.8, 0.6], [-0.6, 0.8], [-0.8, -0.6], [0.6, -0.8]];
        Self {
            tracer: &job.input.tracer,
            places,
            directions: directions.map(|[x, z]| Vec3::new(x, 0.0, z)),
            step: angle * distance,
            angle,
            far: FAR * distance,
        }
    }

    /// Whether nothing is in the way of any place.
    fn is_free(&self, shift: Vec3) -> bool {
        let length = shift.length();
        let is_free = |place: &Vec3| {
            // A surface right at the place may be its own holder. A tenth of the way is left
            // free in front of the next surface.
            !(self.tracer).occluded(*place, shift / length, 1e-3 * length, 1.1 * length)
        };
        length == 0.0 || self.places.iter().all(is_free)
    }

    /// Small steps there and back, as often as there is room for; none if there is no
    /// room at all.
    fn forth_and_back(&self, frames: usize) -> Vec<Pose> {
        let turn = frames / 2;
        let room = |direction: &Vec3| {
            let is_free = |steps: &usize| self.is_free(*steps as f32 * self.step * *direction);
            (1..=turn).rev().find(is_free).unwrap_or(0)
        };
        let mut best = (0, self.directions[0]);
        for direction in self.directions {
            let steps = room(&direction);
            if steps > best.0 {
                best = (steps, direction);
            }
        }
        let (steps, direction) = best;
        if steps == 0 {
            return Vec::new();
        }
        let pose = |frame: usize| {
            // If there is room for fewer steps than frames, they go forth and back again.
            let along = frame.abs_diff(turn) % (2 * steps);
            let along = along.min(2 * steps - along) as f32;
            Pose {
                shift: along * self.step * direction,
                turn: [along * self.angle, 0.0],
            }
        };
        (0..frames).map(pose).collect()
    }

    /// Places in a ball, each drawn by itself.
    fn far_apart(&self, frames: usize) -> Vec<Pose> {
        let mut random = Random::new(SEED);
        let mut pose = || {
            let mut shift = Vec3::ZERO;
            for attempt in 0..TRIES {
                let point = Vec3::from_array(std::array::from_fn(|_| random.between(-1.0, 1.0)));
                let nearer = 1.0 - attempt as f32 / TRIES as f32;
                let found = self.far * nearer * point;
                if shift == Vec3::ZERO && point.length() <= 1.0 && self.is_free(found) {
                    shift = found;
                }
            }
            let turn = std::array::from_fn(|_| random.between(-TURN, TURN));
            Pose { shift, turn }
        };
        (0..frames).map(|_| pose()).collect()
    }
}

/// The mean distance between places and what is seen; 1 m if nothing is.
fn mean_distance(job: &Job<'_>, places: &[Vec3]) -> f32 {
    /// Only every seventh pixel is taken.
    const STRIDE: usize = 7;
    let rays = job.view.rays().iter().step_by(STRIDE);
    let seen = rays.filter(|ray| ray.length().is_finite());
    let seen = seen.map(|ray| ray.origin() + ray.length() * ray.direction());
    let distances = seen.flat_map(|point| places.iter().map(move |place| place.distance(point)));
    let (sum, number) = distances.fold((0.0, 0), |(sum, number), distance| {
        (sum + f64::from(distance), number + 1)
    });
    match number {
        0 => 1.0,
        _ => (sum / f64::from(number)) as f32,
    }
}
