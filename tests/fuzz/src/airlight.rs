//! Airlight by every evaluator, of parts of rays that are hard and of numbers that are none.

use std::f64::consts::PI;
use std::sync::LazyLock;

use airlight::directional::{between, open_air};
use airlight::surface::exact::Lobe;
use airlight::surface::{GlossTable, LobeTable};
use airlight::{
    Emission, Evaluator, Exact, FrameTable, PhaseFunction, Quadrature, Segment, Segment64, Table,
};

use super::Bytes;

/// Evaluators of a phase function, and how wrong each may be.
struct Evaluators {
    exact: Exact,
    table: Option<Table>,
    fine: Quadrature,
    coarse: Quadrature,
}

/// One with a table, which takes a moment to make, and some without.
static ALL: LazyLock<Vec<Evaluators>> = LazyLock::new(|| {
    let with_table = [
        PhaseFunction::Isotropic,
        PhaseFunction::HenyeyGreenstein { g: 0.7 },
    ];
    let without = [
        PhaseFunction::Rayleigh,
        PhaseFunction::Schlick { k: -0.95 },
        PhaseFunction::CornetteShanks { g: 0.9 },
        PhaseFunction::HenyeyGreenstein { g: -0.99 },
        PhaseFunction::DoubleHenyeyGreenstein {
            g: [0.9, -0.4],
            weight: 0.7,
        },
    ];
    let both = with_table.map(|phase| (phase, true)).into_iter();
    both.chain(without.map(|phase| (phase, false)))
        .map(|(phase, with_table)| Evaluators {
            exact: Exact::new(phase).expect("a sound phase function"),
            table: with_table.then(|| Table::new(&phase, 8).expect("a size of tables")),
            fine: Quadrature::with_tolerance(phase, 1e-5).expect("a tolerance"),
            coarse: Quadrature::with_tolerance(phase, 1e-2).expect("a tolerance"),
        })
        .collect()
});

/// Lobes of surfaces, and their tables.
static LOBES: LazyLock<Vec<(f32, Lobe, LobeTable)>> = LazyLock::new(|| {
    let lobe = |exponent: f32| {
        let exact = Lobe::new(f64::from(exponent)).expect("an exponent");
        let table = LobeTable::new(exponent).expect("an exponent");
        (exponent, exact, table)
    };
    [1.0, 2.5, 40.0, 200.0].map(lobe).into()
});

static GLOSS: LazyLock<GlossTable> = LazyLock::new(GlossTable::new);

/// Tables of a frame, for smooth phase functions and sharp ones, through little fog and much.
static FRAMES: LazyLock<Vec<(Exact, FrameTable)>> = LazyLock::new(|| {
    let phases = [
        PhaseFunction::Isotropic,
        PhaseFunction::HenyeyGreenstein { g: 0.7 },
        PhaseFunction::HenyeyGreenstein { g: -0.97 },
        PhaseFunction::DoubleHenyeyGreenstein {
            g: [0.97, -0.9],
            weight: 0.6,
        },
    ];
    let depths = |phase| [0.0, 0.5, 2.0].map(|depth| (phase, depth));
    let table = |(phase, depth): (PhaseFunction, f32)| {
        let table = FrameTable::new(&phase, depth / DISTANCE, DISTANCE, 64);
        let exact = Exact::new(phase).expect("a sound phase function");
        (exact, table.expect("a size of tables"))
    };
    phases.into_iter().flat_map(depths).map(table).collect()
});

/// Of the light from the eye in these frames, m.
const DISTANCE: f32 = 4.0;

/// Any number at all, or one of a magnitude that occurs.
fn number(bytes: &mut Bytes<'_>) -> f32 {
    let extremes = [
        0.0,
        -0.0,
        f32::INFINITY,
        f32::MAX,
        f32::NAN,
        f32::MIN_POSITIVE,
    ];
    match bytes.below(8) {
        0 => bytes.one_of(&extremes),
        1 => bytes.any(),
        2 => bytes.unit(),
        _ => bytes.magnitude(-30.0, 20.0),
    }
}

/// Sunlight in single precision is that in double precision, to the rounding of exponents.
fn of_sun(bytes: &mut Bytes<'_>) {
    let is_close = |single: f32, double: f64, exponent: f32, what: [f32; 3]| {
        assert!(single >= 0.0, "{single} of {what:?}");
        let error = f64::from(f32::EPSILON) * (8.0 + 2.0 * f64::from(exponent));
        // Beyond, the exponential alone is no normal number in single precision.
        let is_normal = exponent < 87.0 && (1e-37..1e38).contains(&double);
        let is_close = (f64::from(single) / double - 1.0).abs() <= error;
        assert!(
            !is_normal || is_close,
            "{single:e} for {double:e} of {what:?}"
        );
    };
    for _ in 0..8 {
        let of = [(); 3].map(|()| number(bytes));
        let [a, b, length] = of;
        let [c, d, long] = of.map(f64::from);
        is_close(open_air(a, b, length), open_air(c, d, long), a * b, of);
        is_close(between(a, b, length), between(c, d, long), a.min(b), of);
    }
}

/// Tables of the light that surfaces receive keep their bound against quadrature.
fn of_surfaces(bytes: &mut Bytes<'_>) {
    for _ in 0..4 {
        let (exponent, exact, table) = &LOBES[bytes.below(LOBES.len())];
        let optical_distance = match bytes.below(4) {
            0 => number(bytes),
            1 => bytes.between(0.0, 90.0),
            _ => bytes.magnitude(-24.0, 6.0),
        };
        let cosine = match bytes.below(4) {
            0 => number(bytes),
            1 => bytes.one_of(&[1.0, -1.0, 0.0, 1e-7]),
            _ => bytes.between(-1.0, 1.0),
        };
        let truth = exact.value(f64::from(optical_distance), f64::from(cosine).acos());
        let values = [
            table.value(optical_distance, cosine),
            GLOSS.value(*exponent, optical_distance, cosine),
        ];
        let is_sound = optical_distance >= 0.0 && (-1.0..=1.0).contains(&cosine);
        for value in values {
            assert!(value >= 0.0, "{value} at {optical_distance:e}, {cosine}");
            let error = (f64::from(value) / truth - 1.0).abs();
            let is_normal = truth >= f64::from(f32::MIN_POSITIVE);
            assert!(
                !(is_sound && is_normal) || error < 1e-4,
                "{value:e} for {truth:e} at {optical_distance:e}, {cosine}, exponent {exponent}"
            );
        }
    }
}

/// Extinction and a part of a ray. Some are any numbers at all.
fn case(bytes: &mut Bytes<'_>) -> (f32, Segment) {
    if bytes.below(8) == 0 {
        let [sigma_t, x, s, h, length] = [(); 5].map(|()| {
            let extremes = [
                0.0,
                -0.0,
                f32::INFINITY,
                f32::MAX,
                f32::NAN,
                f32::MIN_POSITIVE,
            ];
            match bytes.below(3) {
                0 => bytes.one_of(&extremes),
                1 => bytes.magnitude(-20.0, 20.0),
                _ => bytes.any(),
            }
        });
        return (sigma_t, Segment { x, s, h, length });
    }
    // Distances between eye and light from 1e-6 m to 1e6 m.
    let distance = f64::from(bytes.magnitude(-19.9, 19.9));
    let optical = match bytes.below(8) {
        0 => 0.0,
        1 => bytes.between(0.0, 80.0),
        _ => bytes.magnitude(-30.0, 6.3),
    };
    let off = match bytes.below(4) {
        0 => 0.0,
        1 => bytes.magnitude(-30.0, 0.0),
        _ => bytes.between(0.0, 3.2),
    };
    let (sine, cosine) = f64::from(off).sin_cos();
    let cosine = if bytes.flag() { -cosine } else { cosine };
    let start = match bytes.below(4) {
        0 => 0.0,
        1 => cosine,
        2 => f64::from(bytes.magnitude(-20.0, 8.0)),
        _ => f64::from(bytes.between(0.0, 2.0)),
    };
    let length = match bytes.below(4) {
        0 => f64::INFINITY,
        1 => f64::from(bytes.magnitude(-30.0, 8.0)),
        _ => f64::from(bytes.between(0.0, 2.0)),
    };
    let start = start.max(0.0);
    let segment = Segment {
        x: (start * distance) as f32,
        s: ((start - cosine) * distance) as f32,
        h: (sine.abs() * distance) as f32,
        length: (length * distance) as f32,
    };
    ((f64::from(optical) / distance) as f32, segment)
}

/// Whether a number among these is no length and no extinction, so that there is no light.
fn is_nothing(sigma_t: f32, segment: &Segment) -> bool {
    let Segment { x, s, h, length } = *segment;
    let is_finite = x.is_finite() && s.is_finite() && h.is_finite();
    !(is_finite && h >= 0.0 && length >= 0.0 && sigma_t >= 0.0)
}

/// Whether these are lengths and an extinction.
fn is_sound(sigma_t: f32, segment: &Segment) -> bool {
    let Segment { x, s, h, length } = *segment;
    let is_length = |x: f32| x >= 0.0 && x.is_finite();
    is_length(sigma_t) && is_length(x) && s.is_finite() && is_length(h) && length >= 0.0
}

fn check(name: &str, value: f32, truth: f64, bound: f64, case: (f32, Segment)) {
    assert!(value >= 0.0, "{name}: {value} of {case:?}");
    let (sigma_t, segment) = case;
    let normal = f64::from(f32::MIN_POSITIVE) * 1.0001..f64::from(f32::MAX) * 0.9999;
    // The distances that the promises are about.
    let eye = f64::from(segment.s) - f64::from(segment.x);
    let from_light = eye.hypot(f64::from(segment.h));
    if is_sound(sigma_t, &segment) && (1e-6..=1e6).contains(&from_light) && normal.contains(&truth)
    {
        let error = (f64::from(value) / truth - 1.0).abs();
        assert!(
            error <= bound,
            "{name}: {value:e} for {truth:e}, {error:e} of {bound:e}, {case:?}"
        );
    }
}

/// Quadratures keep their tolerance of lights that do not shine evenly.
fn of_light(evaluators: &Evaluators, bytes: &mut Bytes<'_>) {
    let (quadrature, tolerance) = match bytes.flag() {
        true => (&evaluators.fine, 1e-5),
        false => (&evaluators.coarse, 1e-2),
    };
    let tilt = f64::from(bytes.unit());
    let (across, along) = f64::from(bytes.between(-3.2, 3.2)).sin_cos();
    let [across, along] = [across, along].map(|part| part * tilt);
    let outer = f64::from(bytes.magnitude(-9.0, 1.7)).min(PI);
    let inner = outer * f64::from(bytes.unit());
    // Roundings count over the width of the rim.
    let (light, rim) = match bytes.below(3) {
        0 => (Emission::cosine(along, across), 1.0),
        _ => {
            let [inner, outer] = [inner, outer].map(f64::cos);
            let spot = Emission::spot(along, across, inner, outer);
            (spot, (inner - outer).max(1e-3))
        }
    };
    let light = light.expect("parts of a unit vector");
    let range = f64::from(bytes.magnitude(-20.0, 20.0));
    let light = match bytes.below(3) {
        0 => Ok(light),
        1 => light.within(range),
        _ => light.fading_within(range),
    };
    let light = light.expect("a positive range");
    let (sigma_t, segment) = case(bytes);
    let value = quadrature.airlight_of(sigma_t, &segment, &light);
    assert!(
        value >= 0.0,
        "{value} of {light:?}, {sigma_t:e} {segment:?}"
    );
    let wide = Segment64::from(segment);
    let truth = (evaluators.exact).estimate_of(f64::from(sigma_t), &wide, &light);
    assert!(
        truth.value >= 0.0,
        "{truth:?} of {light:?}, {sigma_t:e} {segment:?}"
    );
    let full = (evaluators.exact).airlight(f64::from(sigma_t), &wide);
    let from_light = (wide.s - wide.x).hypot(wide.h);
    let is_promised = is_sound(sigma_t, &segment) && (1e-6..=1e6).contains(&from_light);
    if is_promised && (1e-33..1e38).contains(&full) {
        let roundings = 8.0 * f64::from(f32::EPSILON) / rim;
        let error = (f64::from(value) - truth.value).abs();
        assert!(
            error <= tolerance * truth.value + roundings * full,
            "{value:e} for {truth:?}, {error:e} of {full:e}, {light:?}, {sigma_t:e} {segment:?}"
        );
        assert!(
            truth.value <= full * (1.0 + 1e-9),
            "{truth:?} of {full:e}, {light:?}, {sigma_t:e} {segment:?}"
        );
    }
}

/// What tables of a frame know is within a hundredth of the truth.
fn of_frame(bytes: &mut Bytes<'_>) {
    let (exact, table) = &FRAMES[bytes.below(FRAMES.len())];
    if bytes.below(16) == 0 {
        let [x, s, h, length] = [(); 4].map(|()| number(bytes));
        let found = table.look_up(&Segment { x, s, h, length });
        assert!(found.is_none_or(|found| found >= 0.0), "{found:?}");
        return;
    }
    let angle = match bytes.below(4) {
        0 => PI - f64::from(bytes.magnitude(-20.0, 1.0)),
        1 => f64::from(bytes.magnitude(-20.0, 1.0)),
        _ => PI * f64::from(bytes.unit()),
    };
    let (sine, cosine) = angle.sin_cos();
    let start = match bytes.below(4) {
        0 => 0.0,
        1 => cosine.max(0.0) * f64::from(bytes.between(0.9, 1.1)),
        2 => f64::from(bytes.magnitude(-12.0, 4.0)),
        _ => f64::from(bytes.between(0.0, 3.0)),
    };
    let length = match bytes.below(4) {
        0 => f64::INFINITY,
        1 => f64::from(bytes.magnitude(-12.0, 4.0)),
        _ => f64::from(bytes.between(0.0, 3.0)),
    };
    let distance = f64::from(DISTANCE);
    let segment = Segment {
        x: (start * distance) as f32,
        s: ((start - cosine) * distance) as f32,
        h: (sine * distance) as f32,
        length: (length * distance) as f32,
    };
    let Some(found) = table.look_up(&segment) else {
        return;
    };
    let truth = exact.airlight(table.sigma_t().into(), &Segment64::from(segment));
    let error = (f64::from(found) / truth - 1.0).abs();
    assert!(
        error <= 1e-2,
        "{found:e} for {truth:e}, {error:e}, {segment:?} of {:?} {}",
        exact.phase(),
        table.sigma_t()
    );
}

/// An evaluator keeps its bound in one case, alone and in a batch with others, and gives
/// every one of them a number that is not negative.
///
/// Exact values take the most time: there is one.
fn of_part(exact: &Exact, evaluator: (&str, &dyn Evaluator, f64), bytes: &mut Bytes<'_>) {
    let (name, evaluator, bound) = evaluator;
    // Batches of vectors and what is left over of one.
    let count = 1 + bytes.below(9);
    let asked = bytes.below(count);
    let cases: Vec<(f32, Segment)> = (0..count).map(|_| case(bytes)).collect();
    let (sigma_t, segment) = cases[asked];
    let truth = exact.estimate(f64::from(sigma_t), &Segment64::from(segment));
    let is_value = truth.value >= 0.0 && truth.bound >= 0.0;
    assert!(is_value, "{truth:?} of {sigma_t} {segment:?}");
    if is_nothing(sigma_t, &segment) {
        assert_eq!(truth.value, 0.0, "{sigma_t} {segment:?}");
    }
    let value = evaluator.airlight(sigma_t, &segment);
    check(name, value, truth.value, bound, (sigma_t, segment));
    let segments: Vec<Segment> = cases.iter().map(|case| case.1).collect();
    let mut values = vec![f32::NAN; segments.len()];
    evaluator.airlight_batch(sigma_t, &segments, &mut values);
    check(name, values[asked], truth.value, bound, (sigma_t, segment));
    for (segment, value) in segments.iter().zip(values) {
        assert!(value >= 0.0, "{name}: {value} of {sigma_t} {segment:?}");
        if evaluator.has_independent_batches() {
            let alone = evaluator.airlight(sigma_t, segment);
            assert_eq!(value, alone, "{name}: {sigma_t} {segment:?}");
        }
    }
    for (sigma_t, segment) in &cases {
        let value = evaluator.airlight(*sigma_t, segment);
        assert!(value >= 0.0, "{name}: {value} of {sigma_t} {segment:?}");
    }
}

/// A table or a quadrature keeps its bound against the exact value, of a part alone and
/// in a batch, or closed forms, tables of surfaces and of frames, and quadratures of uneven
/// lights theirs; no number makes a result negative or NaN.
///
/// # Panics
/// If not.
pub fn run(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let evaluators = match bytes.below(ALL.len() + 4) {
        0 => return of_sun(&mut bytes),
        1 => return of_surfaces(&mut bytes),
        2 => return of_frame(&mut bytes),
        3 => return of_light(&ALL[bytes.below(ALL.len())], &mut bytes),
        evaluators => &ALL[evaluators - 4],
    };
    let evaluator: (_, &dyn Evaluator, _) = match (bytes.below(3), &evaluators.table) {
        (0, Some(table)) => ("table", table, f64::from(table.error_bound())),
        (0 | 1, _) => ("quadrature to 1e-5", &evaluators.fine, 1e-5),
        _ => ("quadrature to 1e-2", &evaluators.coarse, 1e-2),
    };
    of_part(&evaluators.exact, evaluator, &mut bytes);
}

/// Cases of every kind for every phase function.
pub fn seeds() -> Vec<Vec<u8>> {
    (0..44_u8)
        .map(|seed| {
            let mut bytes = vec![(seed % 11) * 24, seed.wrapping_mul(7)];
            for i in 0..150_u8 {
                bytes.push(i.wrapping_mul(83) ^ seed.wrapping_mul(29).rotate_left(3));
            }
            bytes
        })
        .collect()
}
