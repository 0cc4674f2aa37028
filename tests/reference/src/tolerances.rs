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
    /// An image by exact intervals and the quadrature that is used unless another is
    /// asked for, and the reference.
    DefaultImage,
    /// The same behind a film whose opacity varies.
    ExactFilm,
    /// The ends of the lit runs of a shadow map and the oracle's.
    MapRunEnds,
    /// A point of a light volume and the texels of its map: sideways, in texels.
    LightVolumeTexel,
    /// The same along the light, in widths of a texel, beside the volume's tolerance.
    LightVolumeDepth,
    /// An image of a room with a caster that is not solid, by a march through maps.
    CasterImage,
    /// A bound on a share of depths from their moments, and the share.
    MomentShare,
    /// Order of convergence expected of a march minus the measured one.
    Order,
    /// The radiance of a ray on the GPU and on the CPU, given the same map.
    GpuRadiance,
    /// The same for a light nearly on the ray, times h / D.
    GpuRadianceNearTheAxis,
    /// Share of rays whose radiance differs by more than that.
    GpuRays,
    /// Share of the nodes of a min-max tree that differ because a texel lies at the border of a slice.
    GpuTreeNodes,
    /// How many nodes of light volumes of both backends differ in more than rounding.
    GpuVolumeNodes,
    /// A height of a vertex, or a bound of heights.
    GpuVolumeHeight,
    /// A filtered moment of depths on the GPU and on the CPU.
    GpuMoments,
    /// The radiance of a ray by froxels on the GPU and on the CPU, given the same map.
    GpuFroxels,
    /// Share of rays whose radiance differs by more because a froxel falls to another texel.
    GpuFroxelRays,
    /// A texel of a shadow map on the GPU and on the CPU.
    GpuTexel,
    /// Share of the texels on an edge that differ by more than that.
    GpuEdgeTexels,
    /// The airlight of a segment on the GPU and on the CPU.
    GpuAirlight,
    /// What optical depth adds to that, per unit.
    GpuAirlightDepth,
    /// Share of the segments that are looked up in a neighbouring cell, or integrated by another rule, on the GPU.
    GpuAirlightBorder,
    /// What optical depth adds to `GpuAirlight` for a sum over nodes, per unit.
    GpuNodesDepth,
    /// A lookup in the published table on the GPU and on the CPU.
    GpuPublishedTable,
    /// What the factor adds to that.
    GpuPublishedTableFactor,
    /// What its exponent adds, per unit.
    GpuPublishedTableDepth,
    /// Light reaching a surface from a table, on the GPU and on the CPU.
    GpuLobe,
    /// WGSL's exponential, per unit of 1 + T for an argument of size T.
    GpuExponential,
    /// Share of rays whose radiance differs because a sample of a march falls to another texel.
    GpuMarchRays,
    /// The same of a march whose borders are found by halving.
    GpuHybridRays,
    /// The radiance of intervals whose ends were found on the GPU and on the CPU.
    GpuIntervals,
    /// Share of rays whose radiance differs by more because an edge that shadows them is almost in
    /// their plane with the light.
    GpuExactRays,
    /// Share of rays whose radiance differs by more because a voxel or a texel falls to the side of another.
    GpuVoxelRays,
    /// The same for precomputed shadows.
    GpuBakedRays,
    /// The light of many lights that gets straight to a point of a surface, on the GPU and on the CPU.
    GpuDirectLight,
    /// Share of points that differ by more because they are at the rim of a narrow cone.
    GpuDirectLightPoints,
    /// The same for points with filtered precomputed shadows.
    GpuFilteredPoints,
    /// The light that hair sends to a pixel, on the GPU and on the CPU.
    GpuHair,
    /// Share of pixels that differ by more because a strand is seen or lit along its axis, or on
    /// the border of a triangle's shadow.
    GpuHairPixels,
    /// What a sample of the transmittance of smoke adds to `GpuRadiance`.
    GpuSmoke,
    /// Share of rays that differ by more because a sample is within rounding of a step of transmittance.
    GpuSmokeRays,
    /// A transmittance behind casters that a shader meets, beside the bounds of curves and what
    /// a depth that is off by 8 units changes.
    GpuMet,
    /// The light that media scatter along a ray, of what it would be without shadows.
    GpuMedia,
    /// Share of rays that differ by more because a step ends elsewhere or falls to the other side of a shadow.
    GpuMediaRays,
    /// A texel of a shadow map of loose triangles on the GPU and on the CPU.
    GpuSoupTexel,
    /// Share of its pairs of texels of different depth at which another triangle may be seen.
    GpuSoupEdgeTexels,
    /// A coordinate of epipolar space on the GPU and on the CPU.
    GpuAngle,
    /// What the rounding of a position in voxels adds to that.
    GpuPosition,
    /// Share of the indices of an index map that differ at silhouettes.
    GpuSilhouetteTexels,
    /// Share of the rays that a query answers from other texels.
    GpuOtherTexel,
    /// What a query may differ by from the same texels.
    GpuQuery,
    /// The ends of the intervals of a query.
    GpuQueryEnds,
    /// A filtered lookup in a DAG on the GPU and on the CPU.
    GpuFilteredShare,
    /// The same with weights.
    GpuWeightedShare,
    /// A length of the lit part of a ray through a DAG.
    GpuLitLength,
    /// A normal in the space of a light.
    GpuTurnedNormal,
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
    /// A pixel between samples that resemble it, on the GPU and on the CPU.
    GpuResemblance,
    /// A pixel between samples of two lines, on the GPU and on the CPU.
    GpuLinesFilled,
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
        derivation: "Root mean square relative to the mean radiance. A quadrature to 1e-6, f32 ends \
            of intervals and f32 sums: 2e-6 of a pixel, some of which are several times as \
            bright as the mean.",
    },
    Tolerance {
        what: Allowed::DefaultImage,
        error: 1e-4,
        derivation: "Root mean square relative to the mean radiance. Each lit part is within \
            1e-4 of itself, so that a picture is within 1e-4 of its own root mean square. That is \
            up to ten times the mean beside a lamp, where parts would have to miss their \
            tolerance by as much less on average: the nodes are as many as the worst needs.",
    },
    Tolerance {
        what: Allowed::ExactFilm,
        error: 1e-3,
        derivation: "Root mean square relative to the mean radiance. The transmittance varies by \
            1/64 over a part, which has its mean: off by 1/128 at the ends, with either sign, and \
            by half of that in the mean of one part. A ray crosses some 16 parts: 1/256 / 4 \
            = 1e-3. The oracle's parts are a thousandth of a ray: less.",
    },
    Tolerance {
        what: Allowed::MapRunEnds,
        error: 2.0 * ULP32,
        derivation: "Times the distance of the farthest end and of the light. An end is rounded to f32 \
            once. Both sides compute in f64, where a ray that touches the sphere of a texel \
            has the square root of a difference of squares of distances, each rounded by \
            2^-53: 1e-8 of the distance.",
    },
    Tolerance {
        what: Allowed::LightVolumeTexel,
        error: 1e-6,
        derivation: "Both sides compute in f64 from the same f32 ray: 2^-53 of the distance to the light over \
            the width of a texel, which is 1e-3 of a distance that may be a millionth of that: 1e-7.",
    },
    Tolerance {
        what: Allowed::LightVolumeDepth,
        error: 2e-3,
        derivation: "A height is rounded to f32 four times, 4 x 2^-24 of the depth. A texel is 1e-3 of \
            the depth wide in the narrowest picture of a lamp, an opening of a tenth in 200 texels: \
            2.4e-4 of it. In parallel light a depth is up to 40 times the width of a picture of 200 texels: \
            40 x 200 x 4 x 2^-24 = 2e-3.",
    },
    Tolerance {
        what: Allowed::CasterImage,
        error: 0.004,
        derivation: "RMSE over the mean. The ends of shadows are off by half a step of 6 m / 128, or by a texel \
            of 6 m / 256 of a map of curves, seen up to three times as long on rays at 20 degrees to the light: \
            0.02 to 0.07 m, with a sign that changes from ray to ray. The shadow of the card is 1.6 m long or more \
            and takes 0.07 of the mean: two ends of 0.07 m / 1.6 m x 0.07, over the square root of two, are \
            0.0043. Without the caster the picture would be off by 0.035 to 0.43.",
    },
    Tolerance {
        what: Allowed::MomentShare,
        error: 1e-6,
        derivation: "Moments are rounded by 2^-53. The pivots of the matrix of 6 moments of 4 depths \
            that lie at least 1/30 apart are products of squares of 3 differences, 1e-8 at \
            the least with a share of 0.01: an error of 1e-16 over 1e-10.",
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
        what: Allowed::GpuTreeNodes,
        error: 5e-3,
        derivation: "A border of a slice is off by about 8 x 2^-24 x 96 = 5e-5 of a texel, so that a \
            texel more or less belongs to a cell with a chance of 1e-4 for its two borders, \
            and to one of the 8 cells of a leaf with 1e-3; a parent has the chances of all of its \
            leaves, but few of their texels are the least or the greatest.",
    },
    Tolerance {
        what: Allowed::GpuVolumeNodes,
        error: 2e-3,
        derivation: "A distance between patch and vertex is off by about 4 x 2^-24 of the height; the \
            tolerance is 1/4 of 2/96 of it, so the two are that close to each other, of tolerances \
            between 0 and twice as much, with a chance of 2e-5 for each vertex. Three quarters of all nodes have 5 that are not \
            corners, three sixteenths 21, and so on: each level has as many vertices in all, so \
            that six levels are off in 6 x 5 x 0.75 x 2e-5 = 4e-4 of the nodes; a parent has the \
            chances of its children, and of the patches that they begin or end.",
    },
    Tolerance {
        what: Allowed::GpuVolumeHeight,
        error: 24.0 * ULP32,
        derivation: "Relative. A square root (9 units of 2^-24), a quotient (5), and two products (2); \
            the place of a texel is a quotient of up to 2 in each direction, off by 10 units, of \
            which a corner of a face of a cube passes on a third each (7).",
    },
    Tolerance {
        what: Allowed::GpuMoments,
        error: 256.0 * ULP32,
        derivation: "Times 1, or the moment where it is one of an exponential. The depth is off by \
            4 units of 1; an exponential of up to 20 times that by 80 units and by the 3 + 2 x \
            20 ULP that WGSL grants it, its square by twice as much.",
    },
    Tolerance {
        what: Allowed::GpuFroxels,
        error: 640.0 * ULP32,
        derivation: "Relative to the brightest ray. 256 units as for `GpuRadiance`; the sample of a \
            froxel is off by 4 units of its coordinates of 10 m or less, and of lights 1 m away and \
            more: 40 units of the distance, 80 of its square; and a ray reads its columns and \
            slices at a place that is off by 4 units of up to 24 borders and tiles, 100 units of \
            the difference between neighbours, three times: along, across and down.",
    },
    Tolerance {
        what: Allowed::GpuFroxelRays,
        error: 6e-3,
        derivation: "For each light. A ray reads four columns of up to 64 froxels. A coordinate of a map \
            of 256 is off by 6e-5 of a texel, so each froxel is within rounding of one of four \
            borders with a chance of 2.4e-4, and at most every tenth is next to a texel of \
            another answer: 4 x 64 x 2.4e-4 / 10 = 6e-3.",
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
        what: Allowed::GpuAirlight,
        error: 300.0 * ULP32,
        derivation: "Relative. A distance from the light is a square root, which WGSL computes as the \
            inverse (2.5 ULP, 5 units of 2^-24) of an inverse square root (2 ULP, 4 units) \
            of a sum of squares (1 unit): 10 units. Everything else is a product of at most \
            10 quotients and roots of such lengths, of which the phase function takes the \
            third power next to a peak: 200 units, and sums of up to 100 positive terms.",
    },
    Tolerance {
        what: Allowed::GpuAirlightDepth,
        error: 24.0 * ULP32,
        derivation: "Relative, per unit of optical depth between eye and light: the 10 units of a \
            distance with the products and sums on the way to the exponent, on both sides.",
    },
    Tolerance {
        what: Allowed::GpuAirlightBorder,
        error: 1e-3,
        derivation: "Such a number is off by about 32 units of 2^-24, and a border is at most every \
            tenth of its magnitude: 4e-5 each for the place of two lookups along two axes, \
            and for the three numbers that choose a rule, of up to 20 pieces.",
    },
    Tolerance {
        what: Allowed::GpuNodesDepth,
        error: 16.0 * ULP32,
        derivation: "Relative, per unit of optical depth: the depth along the ray is formed from \
            rounded lengths, 16 roundings of the way to where the light has faded.",
    },
    Tolerance {
        what: Allowed::GpuPublishedTable,
        error: 64.0 * ULP32,
        derivation: "Times the factor of the difference of two lookups. Each is off by up to 32 \
            roundings of a number of about 1: a few each for the angle, its polynomial and \
            the position in the table, whose last digit counts as one of pi/2, and the same \
            again for the row.",
    },
    Tolerance {
        what: Allowed::GpuPublishedTableFactor,
        error: 16.0 * ULP32,
        derivation: "Relative to the airlight: products and quotients of lengths, on both sides.",
    },
    Tolerance {
        what: Allowed::GpuPublishedTableDepth,
        error: 8.0 * ULP32,
        derivation: "Relative to the airlight, per unit of the exponent, which is rounded four times \
            on either side.",
    },
    Tolerance {
        what: Allowed::GpuLobe,
        error: 4e-5,
        derivation: "Relative. WGSL's logarithms may be off by 3 units: of 5.3, 1.4e-6. With the half \
            of the other one that is 1.5 x 1.4e-6 x 0.094 of the axis of angles, 1.3e-5 of \
            its intervals, and as much of the axis of exponents; the logarithm of G changes \
            by up to 2 per interval along one of them and by less along the other.",
    },
    Tolerance {
        what: Allowed::GpuExponential,
        error: 6.0 * ULP32,
        derivation: "Relative. 3 + 2 T units in the last place, which are two of 2^-24 each, and the \
            rounding of the argument.",
    },
    Tolerance {
        what: Allowed::GpuMarchRays,
        error: 4e-4,
        derivation: "A texel coordinate of a map of 256 is off by about 4 x 2^-24 x 256 = 6e-5, so \
            the chance that a sample lies that close to one of four borders is 2.4e-4. A ray \
            has 16 samples, and at most every tenth is next to a texel of a different \
            answer.",
    },
    Tolerance {
        what: Allowed::GpuHybridRays,
        error: 1e-3,
        derivation: "The 4e-4 of a march of 16 steps. Besides, each of the up to 8 borders of a \
            ray among the casters of the test is looked for at 3 more places, all of them within a step of it. Positions are \
            off by 5e-7 of the ray, on either side of the border: of a step of a sixteenth, \
            1.6e-5, and by the rounding of texel coordinates, which are 6e-5 of a step of a \
            texel at the least and a tenth of that of others. 8 x 3 x 2.2e-5 is 5e-4.",
    },
    Tolerance {
        what: Allowed::GpuIntervals,
        error: 1e-3,
        derivation: "Relative to the unshadowed airlight. An end of an interval is off by about 1e-6 \
            of its distance from the eye; seen from a light at a thousandth of that, the \
            nearest of the rays compared, it is an angle of 1e-3, of the pi over which the \
            airlight is spread evenly.",
    },
    Tolerance {
        what: Allowed::GpuExactRays,
        error: 0.01,
        derivation: "Seen from the light, an end of a lit part is off by some 8 units of 2^-24 times \
            D / h: 4 for the plane of ray and light, a cross product, and 4 for the sums that cut \
            a triangle. The airlight is spread evenly over pi, so 3 of the 16 units of \
            `GpuRadianceNearTheAxis` are used up by an end; next to an edge that meets the ray at \
            an angle a, 3 / a. Of the edges that meet a ray a^2 / 2 do so at less than a: 2 % at 0.2. \
            Of the rays of the test every third passes near the light, and a few in a hundred have \
            more than an end.",
    },
    Tolerance {
        what: Allowed::GpuVoxelRays,
        error: 4e-3,
        derivation: "A position in a volume of 128 is off by about 1e-6 rad on either backend, of \
            voxels of 3 rad / 128 at the narrowest seen, so that the texel of a ray differs \
            for 1e-4 of the rays, and so does the index of a light ray; of the light rays a \
            ray crosses up to 128, of which at most every fourth is at a silhouette.",
    },
    Tolerance {
        what: Allowed::GpuBakedRays,
        error: 0.03,
        derivation: "A ray is off by at most 2^-20 x 256 x 20 of a voxel: 5e-3. Of the up to 60 \
            voxels next to shadows that a ray meets in a grid of 256 one is missed for \
            another with a chance of that, and every tenth of those has another answer and \
            is long enough to be seen.",
    },
    Tolerance {
        what: Allowed::GpuDirectLight,
        error: 256.0 * ULP32,
        derivation: "Relative to the sum of all lights without shadows, and to what was there \
            before. The way to a light is off by a unit of its distance, the length of that by 3 \
            more, and direction, cosine and square have 20 units of it; 3 + 2 tau ULP of WGSL's \
            exponential, with tau up to 10 where the value matters; the factor of a cone has up \
            to 3 units of a cosine over a hundredth of it or more: 200.",
    },
    Tolerance {
        what: Allowed::GpuDirectLightPoints,
        error: 1e-3,
        derivation: "Of narrower rims of cones, the share of the points of a picture that lie in \
            them is less than their part of the sphere.",
    },
    Tolerance {
        what: Allowed::GpuFilteredPoints,
        error: 0.01,
        derivation: "A point is off by at most 2^-20 x 32 x 100 of a voxel of a grid of 32 along \
            each of three axes, so one of a hundred lies so near to a border of the voxel, and a \
            step along its normal as near to one half.",
    },
    Tolerance {
        what: Allowed::GpuHair,
        error: 1e-4,
        derivation: "Of the light of the pixel. Sines and cosines of inclinations are off by 3 \
            units, 2e-7, and the narrowest cone divides them by a variance of 0.0056 in its \
            exponent, where they sum up to terms of 178 that are rounded to 1e-5 each: 6e-5. \
            `GpuSmoke` for the lookup, at points whose fragments make up a part of the pixel.",
    },
    Tolerance {
        what: Allowed::GpuHairPixels,
        error: 1e-3,
        derivation: "A strand seen within 0.01 rad of its axis, where an inclination that is off \
            by 2e-7 changes a reciprocal cosine by more than the above, is one of 200 with \
            directions at random, and has a hundredth of its length across the picture; one pixel \
            in a thousand that a shadow's border crosses has it within rounding of a strand.",
    },
    Tolerance {
        what: Allowed::GpuSmoke,
        error: 5e-5,
        derivation: "Of the unshadowed airlight. A texel coordinate of a map of 128 is off by about 4 \
            x 2^-24 x 128 = 3e-5, across which the transmittance of a bilinear map changes \
            by at most as much. A depth of up to 16 m is off by 4 units of itself, 4e-6 m, \
            times at most 3 / m of extinction: 1.2e-5. A lookup adds 2e-6.",
    },
    Tolerance {
        what: Allowed::GpuSmokeRays,
        error: 4e-4,
        derivation: "A depth that is off by 4e-6 m falls to the other side of a surface for one in \
            1e5 of the samples where surfaces are a metre apart, and a ray has 16 samples: \
            2e-4. At the corner of a cube of maps it falls onto another face, whose border \
            is filtered by itself: as much again.",
    },
    Tolerance {
        what: Allowed::GpuMet,
        error: 1e-4,
        derivation: "For the maps of at most 61 texels per side of candidates_tests.rs. A corner of \
            an outline counts from the first texel of its caster and is off by 2 units of its \
            distance from there, so that the two sides of a strand change its coverage by 1.5e-5 \
            at 64 texels, 1e-6 at 4. `strands_of_every_size...` has six strands with an area, \
            9e-5 if all errors are of one sign. The 2000 of `many_strands_in_smoke...` consist \
            of pieces on up to 4 texels, of a width w of 8e-3 of a texel or more. Behind n \
            that take tau = alpha w each, errors of one sign are n e^(-n tau) alpha 1e-6, at \
            most 1e-6 / (e w): 5e-5. The share that passes a piece is rounded to half a unit, \
            6e-8 / (e tau) together: 1e-5 for an alpha of 0.3. Optical depths of the balls of \
            that test and of `balls_are_met...` are off by 16 units, 1e-6 / e, and by 5e-5 for \
            the one ray in 1e4 whose chord is a hundredth of the diameter. A ray through a grid \
            of grid_candidates_tests.rs is off by 2^-22 of at most 64 cells, 1.5e-5 of a cell, and \
            crosses a plane between cells up to ten times that away where it is oblique; at an \
            optical depth of 0.5 per cell that is 7e-5. A lookup adds 2e-6.",
    },
    Tolerance {
        what: Allowed::GpuMedia,
        error: 3e-4,
        derivation: "256 units for the light that arrives, as for `GpuRadiance`: 3e-5. The optical \
            depth of 100 pieces is off by 120 x 2^-23 of itself, which takes at most 1/e of that: \
            5e-6. The ends of a step, and the centroid of its light, are off by some 8 units of \
            5 m, 5e-6 m or 1.5e-4 of a texel of 3 cm, across which the transmittance of a \
            bilinear map changes by at most as much; `GpuSmoke` for the lookup.",
    },
    Tolerance {
        what: Allowed::GpuMediaRays,
        error: 2e-3,
        derivation: "A step whose centroid is off by 1.5e-4 of a texel falls into another one with \
            twice that chance, and one in ten of those has another answer of the shadow map: \
            1e-3 for 32 steps. A step ends with the part in which it has had its share, of one of \
            three kinds that are known to 1e-6 of a step each: 1e-4. Where it ends elsewhere, \
            shadows are sampled elsewhere. As much again at the borders of voxels.",
    },
    Tolerance {
        what: Allowed::GpuSoupTexel,
        error: 400.0 * ULP32,
        derivation: "Relative. Corners are off by 2 units of their distance, which is up to ten times \
            the depth, on triangles seen at angles down to 3 degrees, 20 times as flat as \
            face on.",
    },
    Tolerance {
        what: Allowed::GpuSoupEdgeTexels,
        error: 0.03125,
        derivation: "Rasterisers snap corners to 1/16 of a texel or finer, which moves an edge by \
            half of that.",
    },
    Tolerance {
        what: Allowed::GpuAngle,
        error: 1.6e-6,
        derivation: "Radians. Twice the 8e-7 that a lattice states for its positions; both compute \
            the same formulas in f32 and differ where a shader fuses multiplications and by \
            its quotients and square roots.",
    },
    Tolerance {
        what: Allowed::GpuPosition,
        error: 3e-5,
        derivation: "Voxels: two roundings of a position of up to 256, 2 x 2^-24 x 256.",
    },
    Tolerance {
        what: Allowed::GpuSilhouetteTexels,
        error: 1e-4,
        derivation: "A light ray is off by 1e-6 m at a distance of 10 m, where the rays of the \
            lattice are 0.05 m apart: 2e-5 of the rays on either side, along two \
            coordinates. To be added to the share along alpha, twice `GpuAngle` over the \
            width of a voxel.",
    },
    Tolerance {
        what: Allowed::GpuOtherTexel,
        error: 1e-3,
        derivation: "1.6e-6 rad on either side of the border of a voxel of about 0.01 rad in two \
            coordinates.",
    },
    Tolerance {
        what: Allowed::GpuQuery,
        error: 4e-3,
        derivation: "Positions along phi are off by 1.6e-6 rad of voxels of 0.01 rad and more, which \
            is 2e-4 of a voxel; where the axis is close (sin alpha >= 0.05) the share \
            between two planes 20 times that.",
    },
    Tolerance {
        what: Allowed::GpuQueryEnds,
        error: 1e-3,
        derivation: "Relative, of at least a metre. An end lies where the ray crosses a border that \
            is off by 1.6e-6 rad; next to the axis (sin alpha >= 0.05) it moves by that over \
            the square of the sine, 6.4e-4 of its distance.",
    },
    Tolerance {
        what: Allowed::GpuFilteredShare,
        error: 3.0 * ULP32,
        derivation: "Of 1. A count, divided: 2.5 ULP of a quotient below 1.",
    },
    Tolerance {
        what: Allowed::GpuWeightedShare,
        error: 16.0 * ULP32,
        derivation: "Of 1. Weights are exact but for two subtractions; products and sums of them, and \
            the quotient.",
    },
    Tolerance {
        what: Allowed::GpuLitLength,
        error: 1e-5,
        derivation: "Relative. Sums of up to a hundred positive terms, 100 units of 2^-24, each a \
            difference of quotients that are good to 2.5 units in the last place.",
    },
    Tolerance {
        what: Allowed::GpuTurnedNormal,
        error: 1e-3,
        derivation: "Of 1. Cross products of three rows of f32 of similar sizes.",
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
    Tolerance {
        what: Allowed::GpuResemblance,
        error: 4e-3,
        derivation: "Relative to the largest light of a sample. The cosine at which a ray meets a \
            plane is at least 0.02, off by 3 · 2^-24 or 9e-6 of it, and e, ten times that, by d = 9e-5. \
            A biweight s changes by 4 sqrt(s) d. A sample next to a pixel that resembles it by s and \
            one furthest away of weight b = 1/1024 (a quarter of 1/4^4, the least) have a mean that \
            changes by 4 sqrt(s) d b / (s + b)^2 of their difference, at most 1.3 d / sqrt(b) = 42 d.",
    },
    Tolerance {
        what: Allowed::GpuLinesFilled,
        error: 1e-6,
        derivation: "Relative to the largest light of a sample. Weights are the same on both. Two \
            interpolations, one inside the other, and the sum with what is there: each is 1 - x, two \
            products and a sum of terms that do not cancel, 3 roundings of 2^-24 deep; 7 in all on \
            each backend, 14 · 2^-24 = 8.4e-7.",
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
