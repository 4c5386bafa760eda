//! One forward and one reverse pass of the residual network over all obstacles.
//!
//! Vectorised *across* obstacles: a group is as many as there are lanes, and several groups go through the network
//! together, so that each weight, once loaded, serves them all. Layer sizes are constants; the code is generic over
//! the lanes and compiled once per kernel. Not here: which kernel runs (`network`).
#![allow(clippy::inline_always)] // see `lanes`

use crate::elementary::{sin_cos, softplus_with_slope};
use crate::encoding::{InputEncoding, LAYER_WIDTHS};
use crate::lanes::{Group, Lanes, MAX_WIDTH};
use crate::weights::{LayerWeights, NetworkWeights};

/// Widest layer.
const WIDEST: usize = 48;
/// Neurons with a sine.
const SINES: usize = 48 + 48 + 24 + 24 + 12 + 12;

/// One layer, one row of weights per output. Both directions read it, which keeps the network within a first-level cache.
struct Layer<const IN: usize, const OUT: usize> {
    weights: [[f32; IN]; OUT],
    bias: [f32; OUT],
}

impl<const IN: usize, const OUT: usize> Layer<IN, OUT> {
    fn new(layer: &LayerWeights) -> Self {
        Self {
            weights: std::array::from_fn(|output| {
                std::array::from_fn(|input| layer.weight[output * IN + input])
            }),
            bias: std::array::from_fn(|output| layer.bias[output]),
        }
    }
}

/// The first layer, by the inputs it takes.
#[allow(clippy::large_enum_variant)] // one per model, and boxed with the other layers
enum FirstLayer {
    Raw(Layer<4, 48>),
    HeadingCosSin(Layer<5, 48>),
    Position(Layer<2, 48>),
}

impl FirstLayer {
    fn new(encoding: InputEncoding, layer: &LayerWeights) -> Self {
        match encoding {
            InputEncoding::Raw => Self::Raw(Layer::new(layer)),
            InputEncoding::HeadingCosSin => Self::HeadingCosSin(Layer::new(layer)),
            InputEncoding::Position => Self::Position(Layer::new(layer)),
        }
    }
}

/// The parameters, laid out for the pass.
pub(crate) struct PassWeights {
    layer0: FirstLayer,
    layer1: Layer<48, 48>,
    layer2: Layer<48, 24>,
    layer3: Layer<24, 24>,
    layer4: Layer<24, 12>,
    layer5: Layer<12, 12>,
    output: Layer<12, 1>,
}

impl PassWeights {
    pub(crate) fn new(weights: &NetworkWeights) -> Box<Self> {
        let layers = weights.layers();
        Box::new(Self {
            layer0: FirstLayer::new(weights.encoding(), &layers[0]),
            layer1: Layer::new(&layers[1]),
            layer2: Layer::new(&layers[2]),
            layer3: Layer::new(&layers[3]),
            layer4: Layer::new(&layers[4]),
            layer5: Layer::new(&layers[5]),
            output: Layer::new(&layers[6]),
        })
    }
}

/// Intermediate results, kept between calls so that none allocates.
pub(crate) struct PassBuffers<M> {
    heading: Vec<M>,
    cosines: Vec<M>,
    front: Vec<M>,
    back: Vec<M>,
}

impl<M: Group> PassBuffers<M> {
    pub(crate) fn new() -> Self {
        let groups = |neurons| vec![M::ZERO; neurons * MAX_WIDTH];
        Self { heading: groups(2), cosines: groups(SINES), front: groups(WIDEST), back: groups(WIDEST) }
    }
}

/// What a pass reads and writes. All slices have the same length, a multiple of every kernel's lanes.
pub(crate) struct PassArguments<'a, M> {
    pub(crate) weights: &'a PassWeights,
    pub(crate) buffers: &'a mut PassBuffers<M>,
    /// Relative states, one slice per component.
    pub(crate) states: [&'a [f32]; 4],
    /// Residuals, out.
    pub(crate) residuals: &'a mut [f32],
    /// Gradient of the residual, one slice per component, out; left alone where the value suffices.
    pub(crate) gradients: Option<[&'a mut [f32]; 4]>,
}

/// Evaluates residuals, and their input gradients where asked for.
#[inline(always)]
pub(crate) fn residuals<L: Lanes>(mut arguments: PassArguments<'_, L::Group>) {
    let groups = arguments.residuals.len() / L::Group::LANES;
    let mut first = 0;
    while first < groups {
        let width = (groups - first).min(L::BLOCKING.width);
        match width {
            2 if L::BLOCKING.width >= 2 => pass::<L, 2>(&mut arguments, first),
            _ => pass::<L, 1>(&mut arguments, first),
        }
        first += width;
    }
}

/// Takes `G` groups from `first` on through the network and back.
#[inline(always)]
fn pass<L: Lanes, const G: usize>(arguments: &mut PassArguments<'_, L::Group>, first: usize) {
    let PassArguments { weights, buffers, states, residuals, gradients } = arguments;
    let PassBuffers { heading, cosines, front, back } = &mut **buffers;
    let heading = &mut heading.as_chunks_mut::<G>().0[..2];
    let front = front.as_chunks_mut::<G>().0;
    let back = back.as_chunks_mut::<G>().0;
    let (cos0, rest) = cosines.as_chunks_mut::<G>().0.split_at_mut(LAYER_WIDTHS[0]);
    let (cos1, rest) = rest.split_at_mut(LAYER_WIDTHS[1]);
    let (cos2, rest) = rest.split_at_mut(LAYER_WIDTHS[2]);
    let (cos3, rest) = rest.split_at_mut(LAYER_WIDTHS[3]);
    let (cos4, cos5) = rest.split_at_mut(LAYER_WIDTHS[4]);
    let lanes = first * L::Group::LANES..(first + G) * L::Group::LANES;

    let states = states.map(|component| &component[lanes.clone()]);
    match &weights.layer0 {
        FirstLayer::Raw(layer) => {
            for component in 0..4 {
                read(states[component], &mut back[component]);
            }
            forward::<L, G, 4, 48>(layer, back, front, cos0);
        }
        FirstLayer::HeadingCosSin(layer) => {
            for (input, component) in [(0, 0), (1, 1), (2, 2), (4, 3)] {
                read(states[component], &mut back[input]);
            }
            for group in 0..G {
                let (sin, cos) = sin_cos(L::load(&back[2][group]));
                cos.store(&mut back[2][group]);
                sin.store(&mut back[3][group]);
            }
            heading.copy_from_slice(&back[2..4]);
            forward::<L, G, 5, 48>(layer, back, front, cos0);
        }
        FirstLayer::Position(layer) => {
            for component in 0..2 {
                read(states[component], &mut back[component]);
            }
            forward::<L, G, 2, 48>(layer, back, front, cos0);
        }
    }
    forward::<L, G, 48, 48>(&weights.layer1, front, back, cos1);
    forward::<L, G, 48, 24>(&weights.layer2, back, front, cos2);
    forward::<L, G, 24, 24>(&weights.layer3, front, back, cos3);
    forward::<L, G, 24, 12>(&weights.layer4, back, front, cos4);
    forward::<L, G, 12, 12>(&weights.layer5, front, back, cos5);

    let output = &weights.output.weights[0];
    for (group, residuals) in residuals[lanes.clone()].chunks_exact_mut(L::Group::LANES).enumerate() {
        let mut y = L::splat(weights.output.bias[0]);
        for input in 0..12 {
            y = L::splat(output[input]).mul_add(L::load(&back[input][group]), y);
        }
        let (residual, slope) = softplus_with_slope(y);
        let mut stored = L::Group::ZERO;
        residual.store(&mut stored);
        stored.write(residuals);
        for input in 0..12 {
            slope.mul(L::splat(output[input])).store(&mut front[input][group]);
        }
    }

    let Some(gradients) = gradients else { return };
    reverse::<L, G, 12, 12>(&weights.layer5, front, back, cos5);
    reverse::<L, G, 24, 12>(&weights.layer4, back, front, cos4);
    reverse::<L, G, 24, 24>(&weights.layer3, front, back, cos3);
    reverse::<L, G, 48, 24>(&weights.layer2, back, front, cos2);
    reverse::<L, G, 48, 48>(&weights.layer1, front, back, cos1);
    let [by_x, by_y, by_heading, by_speed] =
        gradients.each_mut().map(|component| &mut component[lanes.clone()]);
    match &weights.layer0 {
        FirstLayer::Raw(layer) => {
            reverse::<L, G, 4, 48>(layer, back, front, cos0);
            write(&front[2], by_heading);
            write(&front[3], by_speed);
        }
        FirstLayer::HeadingCosSin(layer) => {
            reverse::<L, G, 5, 48>(layer, back, front, cos0);
            // ∂r/∂z₃ = cos z₃ · ∂r/∂(sin z₃) − sin z₃ · ∂r/∂(cos z₃)
            for group in 0..G {
                let (cos, sin) = (L::load(&heading[0][group]), L::load(&heading[1][group]));
                let by_cos = sin.mul(L::load(&front[2][group]));
                let by_sin = cos.mul(L::load(&front[3][group]));
                by_sin.sub(by_cos).store(&mut heading[0][group]);
            }
            write(&heading[0], by_heading);
            write(&front[4], by_speed);
        }
        FirstLayer::Position(layer) => {
            reverse::<L, G, 2, 48>(layer, back, front, cos0);
            by_heading.fill(0.0);
            by_speed.fill(0.0);
        }
    }
    write(&front[0], by_x);
    write(&front[1], by_y);
}

#[inline(always)]
fn read<M: Group, const G: usize>(from: &[f32], to: &mut [M; G]) {
    for (from, to) in from.chunks_exact(M::LANES).zip(to) {
        *to = M::read(from);
    }
}

#[inline(always)]
fn write<M: Group, const G: usize>(from: &[M; G], to: &mut [f32]) {
    for (from, to) in from.iter().zip(to.chunks_exact_mut(M::LANES)) {
        from.write(to);
    }
}

/// `a' = sin(W a + b)`, and keeps `cos(W a + b)` for the way back.
#[inline(always)]
fn forward<L: Lanes, const G: usize, const IN: usize, const OUT: usize>(
    layer: &Layer<IN, OUT>,
    input: &[[L::Group; G]],
    output: &mut [[L::Group; G]],
    cosines: &mut [[L::Group; G]],
) {
    product::<L, G, IN, OUT>(|k, n| layer.weights[n][k], &layer.bias, input, output);
    for (output, cosine) in output[..OUT].iter_mut().zip(&mut cosines[..OUT]) {
        for group in 0..G {
            let (sin, cos) = sin_cos(L::load(&output[group]));
            sin.store(&mut output[group]);
            cos.store(&mut cosine[group]);
        }
    }
}

/// `∂r/∂a = Wᵀ (cos(W a + b) ∘ ∂r/∂a')`.
#[inline(always)]
fn reverse<L: Lanes, const G: usize, const IN: usize, const OUT: usize>(
    layer: &Layer<IN, OUT>,
    by_output: &mut [[L::Group; G]],
    by_input: &mut [[L::Group; G]],
    cosines: &[[L::Group; G]],
) {
    for (by_output, cosine) in by_output[..OUT].iter_mut().zip(&cosines[..OUT]) {
        for group in 0..G {
            L::load(&by_output[group]).mul(L::load(&cosine[group])).store(&mut by_output[group]);
        }
    }
    product::<L, G, OUT, IN>(|k, n| layer.weights[k][n], &[0.0; IN], by_output, by_input);
}

/// `y_n = start_n + Σ_k weight(k, n) x_k`, k ascending, in blocks of outputs whose sums fill the registers.
#[inline(always)]
fn product<L: Lanes, const G: usize, const K: usize, const N: usize>(
    weight: impl Fn(usize, usize) -> f32,
    start: &[f32; N],
    x: &[[L::Group; G]],
    y: &mut [[L::Group; G]],
) {
    // All of this is constant: one branch is compiled. Small layers take the largest block that divides them.
    match L::BLOCKING.block[G - 1].min(N) {
        12 if N.is_multiple_of(12) => blocks::<L, G, 12, K, N>(weight, start, x, y),
        _ if N.is_multiple_of(4) => blocks::<L, G, 4, K, N>(weight, start, x, y),
        _ => blocks::<L, G, N, K, N>(weight, start, x, y),
    }
}

#[inline(always)]
fn blocks<L: Lanes, const G: usize, const B: usize, const K: usize, const N: usize>(
    weight: impl Fn(usize, usize) -> f32,
    start: &[f32; N],
    x: &[[L::Group; G]],
    y: &mut [[L::Group; G]],
) {
    let (x, y) = (&x[..K], &mut y[..N]);
    for block in 0..N / B {
        let mut sums = [[L::splat(0.0); G]; B];
        for row in 0..B {
            sums[row] = [L::splat(start[block * B + row]); G];
        }
        for k in 0..K {
            let mut inputs = [L::splat(0.0); G];
            for group in 0..G {
                inputs[group] = L::load(&x[k][group]);
            }
            for row in 0..B {
                let weight = L::splat(weight(k, block * B + row));
                for group in 0..G {
                    sums[row][group] = weight.mul_add(inputs[group], sums[row][group]);
                }
            }
        }
        for row in 0..B {
            for group in 0..G {
                sums[row][group].store(&mut y[block * B + row][group]);
            }
        }
    }
}
