//! Shadow maps that a renderer has drawn already.

use epipolar::LightRay;
use glam::{Mat4, Vec3, Vec4};

use crate::Error;

/// The largest number of views.
pub const MAX_VIEWS: usize = 16;

/// The views in which a renderer has drawn what a light sees: the single one of a spotlight,
/// six of a cube around a lamp, the cascades of a sun.
///
/// Depths may run either way, from a near plane at 0 or reversed, to a far plane or to
/// infinity: whatever the matrix of a view makes of a point is its depth. Between such
/// depths and the distances that
/// [`Rectify`](crate::Rectify) wants stand the two equations of the matrix,
///
/// ```text
/// depth = z / w,   z = z₀ + t z₁,   w = w₀ + t w₁
/// ```
///
/// along a light ray, so that `t = (depth w₀ − z₀) / (z₁ − depth w₁)`. Reversed depths with
/// a far plane at infinity lose no digits in this.
///
/// Asked are the views in their order, and the first that has anything on the light ray
/// answers: put the finest cascade first.
///
/// ```
/// use epipolar::LightRay;
/// use voxel_shadow::DepthViews;
///
/// // A lamp in a room of 4 m, from whose walls a renderer got depths of 0.1 m / 2 m.
/// let lamp = [0.0, 1.0, 0.0];
/// let views = DepthViews::cube(lamp, 0.1)?;
/// let ray = LightRay { origin: lamp, direction: [0.8, 0.0, 0.6] };
/// let distance = views.first_blocker(&ray, |_face, _at| 0.05);
/// assert!((distance - 2.5).abs() < 1e-5);
/// # Ok::<(), voxel_shadow::Error>(())
/// ```
///
/// On a GPU the textures themselves take part, without a copy: `gpu::DepthLayers`.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthViews {
    matrices: Vec<Mat4>,
    empty: f32,
}

impl DepthViews {
    /// Views with these matrices from the world, in metres, to clip coordinates as wgpu has
    /// them, column by column: what `Mat4` of glam gives as `to_cols_array_2d`. All
    /// perspective ones must be seen from the light, all parallel ones along it.
    ///
    /// `empty` is the depth of texels in which nothing was drawn, to which the map was
    /// cleared: 0 where depths are reversed, else 1.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless there are 1 to [`MAX_VIEWS`], all numbers are finite, and
    /// `empty` is from 0 to 1.
    pub fn new(matrices: &[[[f32; 4]; 4]], empty: f32) -> Result<Self, Error> {
        let bad = |what, value, expected| {
            Err(Error::BadValue {
                what,
                value,
                expected,
            })
        };
        if !(1..=MAX_VIEWS).contains(&matrices.len()) {
            let views = matrices.len() as f64;
            return bad("the number of depth views", views, "1 to 16");
        }
        if !(0.0..=1.0).contains(&empty) {
            return bad("the depth of empty texels", empty.into(), "0 to 1");
        }
        let numbers = matrices.as_flattened().as_flattened();
        if let Some(number) = numbers.iter().find(|number| !number.is_finite()) {
            let value = f64::from(*number);
            return bad("a number of a matrix", value, "a finite one");
        }
        let matrices = matrices.iter().map(Mat4::from_cols_array_2d).collect();
        Ok(Self { matrices, empty })
    }

    /// The six faces of a cube map around a lamp, in the order of its layers (+x, −x, +y,
    /// −y, +z, −z) and turned as shaders sample cubes; depths are `near` over the distance
    /// along the axis of the face, which is reversed with a far plane at infinity.
    ///
    /// A renderer may draw with [`DepthViews::matrix`]. Cube maps are left-handed:
    /// triangles change the side from which they go round.
    ///
    /// # Errors
    /// [`Error::BadValue`] unless `near` is positive and all numbers are finite.
    pub fn cube(light: impl Into<[f32; 3]>, near: f32) -> Result<Self, Error> {
        if !(near > 0.0 && near < f32::INFINITY) {
            return Err(Error::BadValue {
                what: "the near plane of a cube map",
                value: near.into(),
                expected: "positive and finite",
            });
        }
        let light = Vec3::from(light.into());
        let faces = CUBE.map(|[right, up, forward]| {
            let row = |axis: Vec3| axis.extend(-axis.dot(light));
            let depth = Vec4::new(0.0, 0.0, 0.0, near);
            let rows = [row(right), row(up), depth, row(forward)];
            Mat4::from_cols_array_2d(&rows.map(|row| row.to_array()))
                .transpose()
                .to_cols_array_2d()
        });
        Self::new(&faces, 0.0)
    }

    /// How many views there are.
    pub fn len(&self) -> usize {
        self.matrices.len()
    }

    /// False: there is at least one view.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The matrix of a view, column by column.
    ///
    /// # Panics
    /// If there is no such view.
    pub fn matrix(&self, view: usize) -> [[f32; 4]; 4] {
        self.matrices[view].to_cols_array_2d()
    }

    /// The depth of what is empty.
    pub fn empty(&self) -> f32 {
        self.empty
    }

    /// Where a light ray is in a view: from (0, 0) in the upper left corner of the texture
    /// to (1, 1). `None` beside it, and behind it.
    ///
    /// # Panics
    /// If there is no such view.
    pub fn place(&self, view: usize, ray: &LightRay) -> Option<[f32; 2]> {
        let [base, along] = self.ends(view, ray);
        // The point a metre along the ray serves as well as any other in front of the view.
        let point = base + along;
        let inside = point.w > 0.0 && point.x.abs() <= point.w && point.y.abs() <= point.w;
        inside.then(|| [0.5 + 0.5 * point.x / point.w, 0.5 - 0.5 * point.y / point.w])
    }

    /// The distance along a light ray at which it has a depth in a view, m.
    ///
    /// # Panics
    /// If there is no such view.
    pub fn distance(&self, view: usize, ray: &LightRay, depth: f32) -> f32 {
        let [base, along] = self.ends(view, ray);
        (depth * base.w - base.z) / (along.z - depth * along.w)
    }

    /// The distance of the first blocker of a light ray, +∞ if no view has one: what
    /// [`FirstBlocker`](crate::FirstBlocker) asks for. `depth` reads the map of a view at a
    /// [place](DepthViews::place).
    pub fn first_blocker(&self, ray: &LightRay, depth: impl Fn(usize, [f32; 2]) -> f32) -> f32 {
        let mut found = (0..self.len()).filter_map(|view| {
            let depth = depth(view, self.place(view, ray)?);
            (depth != self.empty).then(|| self.distance(view, ray, depth))
        });
        found.next().unwrap_or(f32::INFINITY)
    }

    /// Clip coordinates of the origin of a ray, and by how much they grow per metre.
    fn ends(&self, view: usize, ray: &LightRay) -> [Vec4; 2] {
        let matrix = &self.matrices[view];
        [
            *matrix * Vec3::from(ray.origin).extend(1.0),
            *matrix * Vec3::from(ray.direction).extend(0.0),
        ]
    }
}

/// To the right, up and forward on the faces of a cube.
const CUBE: [[Vec3; 3]; 6] = [
    [Vec3::NEG_Z, Vec3::Y, Vec3::X],
    [Vec3::Z, Vec3::Y, Vec3::NEG_X],
    [Vec3::X, Vec3::NEG_Z, Vec3::Y],
    [Vec3::X, Vec3::Z, Vec3::NEG_Y],
    [Vec3::X, Vec3::Y, Vec3::Z],
    [Vec3::NEG_X, Vec3::Y, Vec3::NEG_Z],
];

#[cfg(test)]
mod tests {
    use glam::camera::rh::proj::directx::{
        orthographic, perspective, perspective_infinite_reverse,
    };
    use glam::camera::rh::view::look_to_mat4;

    use super::*;

    /// What a renderer draws: the depth of a point in a view.
    fn depth(views: &DepthViews, view: usize, point: Vec3) -> f32 {
        let clip = views.matrices[view] * point.extend(1.0);
        clip.z / clip.w
    }

    /// Points on all sides, at 10 cm to 100 m.
    fn points() -> impl Iterator<Item = Vec3> {
        (1..2000_u32).map(|i| {
            let share = |k: u32| {
                let bits = (4 * i + k).wrapping_mul(2_654_435_761);
                (bits ^ bits >> 15).wrapping_mul(0x9E37_79B9) as f32 / 4_294_967_296.0
            };
            let way = Vec3::new(share(0), share(1), share(2)) - 0.5;
            way.normalize_or(Vec3::X) * (10.0_f32).powf(3.0 * share(3) - 1.0)
        })
    }

    fn ray(origin: Vec3, towards: Vec3) -> LightRay {
        LightRay {
            origin: origin.into(),
            direction: towards.normalize().into(),
        }
    }

    #[test]
    fn faces_of_a_cube_find_the_distance_of_what_is_drawn_in_them() {
        let lamp = Vec3::new(3.0, -2.0, 5.0);
        let views = DepthViews::cube(lamp, 0.05).unwrap();
        for way in points() {
            let ray = ray(lamp, way);
            let seen: Vec<usize> = (0..6).filter(|&f| views.place(f, &ray).is_some()).collect();
            assert_eq!(seen.len(), 1, "{way}: {seen:?}");
            let found = views.first_blocker(&ray, |face, _| depth(&views, face, lamp + way));
            assert!(
                (found - way.length()).abs() < 1e-5 * way.length() + 1e-5,
                "{way}: {found}"
            );
        }
        // +x, −x, +y, −y, +z, −z, and its corners as shaders sample cubes.
        for (face, axis) in [
            Vec3::X,
            Vec3::NEG_X,
            Vec3::Y,
            Vec3::NEG_Y,
            Vec3::Z,
            Vec3::NEG_Z,
        ]
        .into_iter()
        .enumerate()
        {
            let [x, y] = views.place(face, &ray(lamp, axis)).unwrap();
            assert!((x - 0.5).abs() < 1e-6 && (y - 0.5).abs() < 1e-6);
        }
        let corner = views
            .place(0, &ray(lamp, Vec3::new(1.0, 0.9, 0.9)))
            .unwrap();
        assert!(corner[0] < 0.1 && corner[1] < 0.1, "{corner:?}");
        let corner = views
            .place(2, &ray(lamp, Vec3::new(0.9, 1.0, 0.9)))
            .unwrap();
        assert!(corner[0] > 0.9 && corner[1] > 0.9, "{corner:?}");
    }

    #[test]
    fn depths_that_are_not_reversed_and_parallel_ones_work_alike() {
        let spot = Vec3::new(0.0, 4.0, 0.0);
        let down = look_to_mat4(spot, Vec3::NEG_Y, Vec3::X);
        for projection in [
            perspective(1.5, 1.0, 0.1, 200.0),
            perspective_infinite_reverse(1.5, 1.0, 0.1),
        ] {
            let views = DepthViews::new(&[(projection * down).to_cols_array_2d()], 1.0).unwrap();
            for way in points().filter(|way| way.y < -0.9 * way.length() && way.length() < 20.0) {
                let found = views.distance(0, &ray(spot, way), depth(&views, 0, spot + way));
                // Depths next to 1 have lost what they were rounded by, twice the square
                // of the distance over the near plane.
                let allowed = 1e-5 + 2e-6 * way.length_squared();
                assert!((found - way.length()).abs() < allowed, "{way}: {found}");
            }
            assert_eq!(views.place(0, &ray(spot, Vec3::Y)), None);
        }
        // A sun: rays begin level with the eye, and blockers may be behind that.
        let sun = orthographic(-8.0, 8.0, -8.0, 8.0, -50.0, 50.0) * down;
        let views = DepthViews::new(&[sun.to_cols_array_2d()], 1.0).unwrap();
        let ray = ray(Vec3::new(2.0, 1.0, -3.0), Vec3::NEG_Y);
        for height in [20.0, 1.5, -7.0] {
            let blocker = Vec3::new(2.0, height, -3.0);
            let found = views.first_blocker(&ray, |_, _| depth(&views, 0, blocker));
            assert!((found - (1.0 - height)).abs() < 1e-4, "{found}");
        }
    }

    #[test]
    fn the_finest_cascade_with_something_on_the_ray_answers() {
        let cascade = |half: f32| {
            let across = orthographic(-half, half, -half, half, -50.0, 50.0);
            (across * look_to_mat4(Vec3::ZERO, Vec3::NEG_Y, Vec3::X)).to_cols_array_2d()
        };
        let views = DepthViews::new(&[cascade(4.0), cascade(16.0)], 1.0).unwrap();
        let at = |x: f32| ray(Vec3::new(x, 0.0, 0.0), Vec3::NEG_Y);
        let depths = |empty: [bool; 2]| {
            move |view: usize, _: [f32; 2]| {
                if empty[view] {
                    1.0
                } else {
                    0.5 + 0.1 * view as f32
                }
            }
        };
        let near = |a: f32, b: f32| (a - b).abs() < 1e-4;
        assert!(near(
            views.first_blocker(&at(1.0), depths([false, false])),
            0.0
        ));
        assert!(near(
            views.first_blocker(&at(1.0), depths([true, false])),
            10.0
        ));
        assert!(near(
            views.first_blocker(&at(9.0), depths([false, false])),
            10.0
        ));
        assert_eq!(
            views.first_blocker(&at(1.0), depths([true, true])),
            f32::INFINITY
        );
        assert_eq!(
            views.first_blocker(&at(40.0), depths([false, false])),
            f32::INFINITY
        );
    }

    #[test]
    fn what_is_no_view_is_refused() {
        let one = Mat4::IDENTITY.to_cols_array_2d();
        let mut endless = one;
        endless[2][1] = f32::NAN;
        for (matrices, empty) in [
            (vec![], 1.0),
            (vec![one; MAX_VIEWS + 1], 1.0),
            (vec![one], f32::NAN),
            (vec![one], 1.5),
            (vec![endless], 1.0),
        ] {
            let error = DepthViews::new(&matrices, empty);
            assert!(matches!(error, Err(Error::BadValue { .. })));
        }
        for near in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(DepthViews::cube([0.0; 3], near).is_err());
        }
        assert!(DepthViews::cube([f32::NAN; 3], 0.1).is_err());
    }
}
