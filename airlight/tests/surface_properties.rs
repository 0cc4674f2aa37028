//! What must hold for the light that reaches surfaces through fog.

use std::f64::consts::PI;

use airlight::surface::exact::Lobe;
use airlight::surface::{GlossTable, LobeTable};
use proptest::prelude::*;

fn optical_distance() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), (-8.0..2.0_f64).prop_map(|e| 10_f64.powf(e))]
}

fn exponent() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(1.0),
        Just(200.0),
        (0.0..1.0_f64).prop_map(|e| 200_f64.powf(e))
    ]
}

fn angle() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        Just(0.5 * PI),
        Just(PI),
        0.0..PI,
        (-9.0..-1.0_f64).prop_map(|e| 10_f64.powf(e)),
        (-9.0..-1.0_f64).prop_map(|e| 0.5 * PI + 10_f64.powf(e)),
    ]
}

proptest! {
    #![proptest_config(reference::property::cases(128))]

    /// The fog is brightest towards the lamp, and every lobe falls away from
    /// its axis, so turning the lobe away from the lamp loses light.
    #[test]
    fn light_falls_as_the_lobe_turns_away(
        n in exponent(), t in optical_distance(), theta in angle(), step in 1e-3..1.0_f64,
    ) {
        let lobe = Lobe::new(n).unwrap();
        let (near, far) = (lobe.scaled(t, theta), lobe.scaled(t, (theta + step).min(PI)));
        prop_assert!(far <= near * (1.0 + 1e-10), "{near} {far}");
    }

    /// A sharper lobe lies within a blunter one.
    #[test]
    fn light_falls_with_the_exponent(
        n in exponent(), t in optical_distance(), theta in angle(), factor in 1.0..2.0_f64,
    ) {
        let sharper = Lobe::new((n * factor).min(200.0)).unwrap().scaled(t, theta);
        let blunter = Lobe::new(n).unwrap().scaled(t, theta);
        prop_assert!(sharper <= blunter * (1.0 + 1e-10), "{sharper} {blunter}");
    }

    #[test]
    fn light_falls_with_the_distance(
        n in exponent(), t in optical_distance(), theta in angle(), factor in 1.0..3.0_f64,
    ) {
        let lobe = Lobe::new(n).unwrap();
        prop_assert!(lobe.scaled(t * factor, theta) <= lobe.scaled(t, theta) * (1.0 + 1e-10));
    }

    /// Both lobes of an axis and its opposite, with exponent 2, about three
    /// axes at right angles cover every direction once: cos² sum to 1.
    #[test]
    fn squared_lobes_about_three_axes_sum_to_the_whole_sphere(
        t in optical_distance(), theta in 0.0..PI, phi in 0.0..PI,
    ) {
        let lobe = Lobe::new(2.0).unwrap();
        let axes = [theta.cos(), theta.sin() * phi.cos(), theta.sin() * phi.sin()];
        let sum: f64 = axes
            .iter()
            .map(|c| lobe.scaled(t, c.acos()) + lobe.scaled(t, (-c).acos()))
            .sum();
        let whole = 2.0 * PI * airlight::point_spread::exact::total(t);
        // 1e-10 on either side.
        prop_assert!((sum / whole - 1.0).abs() < 2e-10, "{sum} {whole}");
    }
}

/// A sharp lobe of exponent n is a delta of weight 2π/(n+1), to first order in
/// 1/n; where the fog is not steep the rest is small.
#[test]
fn a_sharp_lobe_sees_the_airlight_of_its_axis() {
    for t in [0.0, 0.3, 3.0] {
        for theta in [1.0, 2.0, 3.0] {
            let seen = Lobe::new(200.0).unwrap().scaled(t, theta) * 201.0 / (2.0 * PI);
            let axis = 2.0 * PI * airlight::point_spread::exact::value(t, theta);
            // The mean of the Laplacian over a lobe of variance 1/n per axis,
            // and N'' + N' cot γ is at most a few N here.
            assert!((seen / axis - 1.0).abs() < 0.03, "T {t}, theta {theta}");
        }
    }
}

/// In f32 the table may not fall everywhere by its last digits, but it must
/// not rise by more than them.
#[test]
fn tables_fall_away_from_the_lamp() {
    let lambertian = LobeTable::lambertian();
    let gloss = GlossTable::new();
    for t in [0.0, 1e-3, 0.5, 7.0, 50.0] {
        let mut last = [f32::INFINITY; 2];
        for i in 0..=2000 {
            let cos = 1.0 - i as f32 / 1000.0;
            let now = [lambertian.value(t, cos), gloss.value(12.5, t, cos)];
            for (last, now) in last.iter().zip(now) {
                assert!(now <= last * (1.0 + 3e-6), "T {t}, cos {cos}: {last} {now}");
            }
            last = now;
        }
    }
}
