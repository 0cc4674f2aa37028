//! Every error that a test allows, with the reason why it is that large.

/// The rounding of one f32 operation, 2⁻²⁴.
pub const ULP32: f64 = 0.5 * f32::EPSILON as f64;

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Allowed {
    /// The oracle's airlight and the closed form.
    ClosedForm,
    /// The oracle in a scene and in the same scene moved, turned or scaled.
    Symmetry,
    /// The oracle on a ray and on the parts of it.
    Additivity,
    /// The ends of the oracle's lit intervals found with and without the tree.
    SearchEnds,
    /// The ends of the oracle's lit intervals and analytic ones.
    AnalyticEnds,
    /// The ends of `Exact`'s lit intervals and the oracle's.
    ExactEnds,
    /// The airlight by quadrature with many nodes and the oracle's.
    Quadrature,
    /// The exact airlight of a segment, and the oracle's.
    ExactAirlight,
    /// The airlight by an evaluator that keeps a tolerance of 1e-5, and the
    /// oracle's.
    Evaluator,
    /// An image by exact intervals and quadrature, and the reference.
    ExactImage,
    /// Order of convergence expected of a march minus the measured one.
    Order,
    /// The radiance of a ray on the GPU and on the CPU, given the same map.
    GpuRadiance,
    /// The same for a light nearly on the ray, times h / D.
    GpuRadianceNearTheAxis,
    /// Share of rays whose radiance differs by more than that.
    GpuRays,
    /// A texel of a shadow map on the GPU and on the CPU.
    GpuTexel,
    /// Share of the texels on an edge that differ by more than that.
    GpuEdgeTexels,
    /// Light that reaches surfaces by way of the fog in closed form, and the oracle's.
    SurfaceClosedForm,
    /// The same by a quadrature of 16 nodes.
    SurfaceQuadrature,
    /// What is seen of an environment through fog, and the oracle's.
    Environment,
    /// The light of an environment on a surface, and the oracle's.
    EnvironmentLight,
    /// Light of surfaces on the GPU and on the CPU.
    GpuSurface,
}

/// A row of the table.
#[derive(Debug, Clone, Copy)]
pub struct Tolerance {
    /// What is compared.
    pub what: Allowed,
    /// Largest allowed error; relative to what, the derivation says.
    pub error: f64,
    /// Where the number comes from.
    pub derivation: &'static str,
}

/// The table.
pub const TABLE: &[Tolerance] = &[
    Tolerance {
        what: Allowed::ClosedForm,
        error: 1e-9,
        derivation: "Relative to the sum of the two terms of the closed form, whose difference \
            cancels. Its E(z) is good to 1e-13 of the modulus, and Im E can be smaller than the \
            modulus by h/(s + d), 1e-3 in the test: 1e-10. The quadrature is asked for 1e-11.",
    },
    Tolerance {
        what: Allowed::Symmetry,
        error: 1e-8,
        derivation: "Relative to the unshadowed airlight. Turning a scene of size 10 in f64 moves \
            a shadow's end by 1e-15 × 10, magnified by at most (distance to the light) / (distance \
            of light and blocker) and by 1 / sin of the angle between ray and light, 1e5 together \
            for what the generator makes: 1e-9. Quadrature is asked for 1e-10 on either side.",
    },
    Tolerance {
        what: Allowed::Additivity,
        error: 1e-9,
        derivation: "Relative to the whole. Each of three integrals is asked for 1e-10; the \
            parts' ends are the same f64.",
    },
    Tolerance {
        what: Allowed::SearchEnds,
        error: 0.0,
        derivation: "The same triangles, the same arithmetic, a union that does not depend on \
            their order: the same bits.",
    },
    Tolerance {
        what: Allowed::AnalyticEnds,
        error: 1e-9,
        derivation: "Metres. Coordinates of size 10 and analytic values in f64, magnification at \
            most 1e4: 1e-11, and as much again for the other side.",
    },
    Tolerance {
        what: Allowed::ExactEnds,
        error: 4.0 * ULP32,
        derivation: "Relative to the distance of the end from the eye, or the size of the scene if \
            that is more. Both compute in f64 and one rounds the end to f32 (1 unit of 2^-24); \
            the f64 parts differ by 1e-15 magnified at most 1e7 (grazing), 1e-8.",
    },
    Tolerance {
        what: Allowed::Quadrature,
        error: 256.0 * ULP32,
        derivation: "Relative to the airlight of the light without its cone and range, whose \
            edges f32 resolves no better. 512 nodes, summed in f32: up to 256 half roundings on \
            average of one sign, which outweighs those of exp(-tau) (tau × 2^-24, and where tau \
            exceeds 20 the light is outshone by nearer parts) and of the phase function. A kink \
            inside the interval costs 512^-2 = 4e-6 besides.",
    },
    Tolerance {
        what: Allowed::ExactAirlight,
        error: 2e-9,
        derivation: "The oracle is asked for 1e-9 of the value, the evaluator for 1e-12; as \
            much again, because the oracle's bound is an estimate.",
    },
    Tolerance {
        what: Allowed::Evaluator,
        error: 3e-5,
        derivation: "Relative to the airlight of the light without its cone and range. The \
            tolerance asked for, 1e-5; positions along the ray are f32 and at most 40 of the \
            light's distances away, so that distances to a light are off by 40 × 2^-24 of \
            themselves, and the inverse square by twice that: 5e-6; and patterns and ways \
            through a box vary along a piece, for which as much is allowed as for the rest.",
    },
    Tolerance {
        what: Allowed::ExactImage,
        error: 1e-5,
        derivation: "Root mean square relative to the mean radiance. 512 nodes: 512^-2 = 4e-6 at \
            the kinks of cones; f32 ends of intervals and f32 sums: 1e-6 of a pixel.",
    },
    Tolerance {
        what: Allowed::Order,
        error: 0.25,
        derivation: "Slope of log error over log samples, fitted over a factor of 8, four points. \
            Errors at shadow edges are pseudo-random with a spread that falls by the expected \
            order; over 500 rays the mean square of the error scatters by about 15 % per sample \
            count, its root by 8 %, which tilts the fit by 0.05; features smaller than a step, \
            and pixels beside a lamp that dominate a mean square, tilt it by several times that \
            at the coarse end.",
    },
    Tolerance {
        what: Allowed::GpuRadiance,
        error: 256.0 * ULP32,
        derivation: "Relative to the unshadowed airlight of the light without its cone. Rounding \
            in the evaluation, 3 + 2 tau ULP of WGSL's exponential (tau up to 10 where the value \
            matters), and the error 2 units of cos theta times the steepest phase function, \
            3 g / (1 - g)^2 = 60 at g = 0.8.",
    },
    Tolerance {
        what: Allowed::GpuRadianceNearTheAxis,
        error: 16.0 * ULP32,
        derivation: "Times D / h. The distance h of light and ray is a cross product of vectors \
            of the length D, which f32 gets to 4 units of D and the CPU forms in f64; radiance \
            goes like 1 / h, and phase and emission turn with it, up to a few times as fast.",
    },
    Tolerance {
        what: Allowed::GpuRays,
        error: 0.01,
        derivation: "A sample within rounding of the border of a texel falls to its other side. \
            A texel coordinate of a map of 256 is off by about 4 units x 256 = 6e-5, so a \
            sample is that close to one of four borders with a chance of 2.4e-4. A ray has 32 \
            samples, and up to all of them lie next to a texel of another answer (hair, \
            fences): 0.8 %.",
    },
    Tolerance {
        what: Allowed::GpuTexel,
        error: 4096.0 * ULP32,
        derivation: "Relative. Corners are off by 2 units of the coordinates, which are up to \
            ten times the depth, on triangles seen at angles down to a third of a degree, 200 \
            times as steep as face on: 4000 units.",
    },
    Tolerance {
        what: Allowed::GpuEdgeTexels,
        error: 0.0625,
        derivation: "Rasterisers snap corners to 1/16 of a texel or finer (256 steps on most), \
            which moves an edge by up to half of that, to either side of a texel's centre.",
    },
    Tolerance {
        what: Allowed::SurfaceClosedForm,
        error: 1.2e-4,
        derivation: "Relative. 1e-4 of the spline of G_0; T and cos theta in f32, by which the \
            logarithm of G changes at most like T: 20 units of 2^-24 at T = 20; 1e-5 of the oracle.",
    },
    Tolerance {
        what: Allowed::SurfaceQuadrature,
        error: 5e-3,
        derivation: "Relative to the light on the side that receives most. 32 planes meet kinks where the \
            surface, the cone or a face of the box begins to limit them, and a midpoint rule is \
            off by 1/(12 · 32^2) = 8e-5 of 2 pi of the jump of the slope at each; there are up to ten, \
            whose jumps are up to the light itself: 10 · 2 pi · 8e-5 = 5e-3. Inside of its limits the \
            integrand is smooth, and 16 nodes are exact to degree 31.",
    },
    Tolerance {
        what: Allowed::Environment,
        error: 2e-3,
        derivation: "Relative. Interpolation between texels 2 pi / 128 apart of a picture of spherical \
            harmonics up to degree 1: (2 pi / 128)^2 / 8 = 3e-4 along either axis; texels are means, as \
            much again; weights of the convolution 1.5e-4; 1e-4 of the oracle.",
    },
    Tolerance {
        what: Allowed::EnvironmentLight,
        error: 5e-3,
        derivation: "Relative to pi times the mean. 288 patches, exact but for those on the horizon: \
            of 24 such patches of 15 degrees, each sends at most 0.068 sr × sin 7.5 degrees / 4 if \
            the horizon halves it, 1.7 % together. The cosines in a patch are taken as evenly \
            spread, which they are where the horizon runs along its sides; along a diagonal they \
            are peaked, and a quarter of it is missing: 0.4 %. Radiance varies by \
            0.13 over a patch, which is of second order.",
    },
    Tolerance {
        what: Allowed::GpuSurface,
        error: 4e-4,
        derivation: "Relative to the largest of the picture. Tables: 4e-5 for WGSL's logarithms. \
            Quadratures: angles of 2e-7 in polynomials, and where sin(phi + gamma) is small, the last \
            nodes before pi, d and r are off by 2e-7 / 0.005 of themselves and with them the exponent, \
            by 4e-5 tau; 3 + 2 tau units of the exponential; steep phase functions 60 times the error \
            of the angle; sums of up to 8192 terms in f32, in one order: 8192 / 2 · 2^-24 = 2.4e-4.",
    },
];

impl Allowed {
    /// The row of this comparison.
    ///
    /// # Panics
    /// If the table has no such row, which a test excludes.
    pub fn row(self) -> &'static Tolerance {
        TABLE
            .iter()
            .find(|row| row.what == self)
            .expect("a row for every comparison")
    }

    /// The largest allowed error.
    pub fn error(self) -> f64 {
        self.row().error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_the_only_one_of_its_kind_and_gives_a_reason() {
        for (index, row) in TABLE.iter().enumerate() {
            assert!(TABLE[..index].iter().all(|other| other.what != row.what));
            assert!(row.error >= 0.0 && row.derivation.len() > 40, "{row:?}");
            assert_eq!(row.what.error(), row.error);
        }
    }
}
