//! One forward and one reverse pass of the residual network over all obstacles.
//!
//! Vectorised *across* obstacles: a group is eight of them, and up to three groups go through the network
//! together, so that each weight, once loaded, serves 24 obstacles. Layer sizes are constants; the code is
//! generic over the lanes and compiled once per kernel. Not here: which kernel runs (`network`).
#![allow(clippy::inline_always)] // see `lanes`

use crate::elementary::{sin_cos, softplus_with_slope};
use crate::encoding::{InputEncoding, LAYER_WIDTHS};
use crate::lanes::{Group, Lanes};
use crate::weights::{LayerWeights, NetworkWeights};

/// Groups that go through the network together at most.
const MAX_WIDTH: usize = 3;
/// Widest layer.
const WIDEST: usize = 48;
/// Neurons with a sine.
const SINES: usize = 48 + 48 + 24 + 24 + 12 + 12;

/// One layer, stored for both directions so that each reads consecutive weights.
struct Layer<const IN: usize, const OUT: usize> {
    by_input: [[f32; OUT]; IN],
    by_output: [[f32; IN]; OUT],
    bias: [f32; OUT],
}

impl<const IN: usize, const OUT: usize> Layer<IN, OUT> {
    fn new(layer: &LayerWeights) -> Self {
        let weight = |output: usize, input: usize| layer.weight[output * IN + input];
        Self {
            by_input: std::array::from_fn(|input| std::array::from_fn(|output| weight(output, input))),
            by_output: std::array::from_fn(|output| std::array::from_fn(|input| weight(output, input))),
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
pub(crate) struct PassBuffers {
    heading: Vec<Group>,
    cosines: Vec<Group>,
    front: Vec<Group>,
    back: Vec<Group>,
}

impl PassBuffers {
    pub(crate) fn new() -> Self {
        let groups = |neurons| vec![Group::ZERO; neurons * MAX_WIDTH];
        Self { heading: groups(2), cosines: groups(SINES), front: groups(WIDEST), back: groups(WIDEST) }
    }
}

/// What a pass reads and writes. All group slices have the same length.
pub(crate) struct PassArguments<'a> {
    pub(crate) weights: &'a PassWeights,
    pub(crate) buffers: &'a mut PassBuffers,
    /// Relative states, one slice per component.
    pub(crate) states: [&'a [Group]; 4],
    /// Residuals, out.
    pub(crate) residuals: &'a mut [Group],
    /// Gradient of the residual, one slice per component, out; left alone where the value suffices.
    pub(crate) gradients: Option<[&'a mut [Group]; 4]>,
}

/// Evaluates residuals, and their input gradients where asked for.
#[inline(always)]
pub(crate) fn residuals<L: Lanes>(mut arguments: PassArguments<'_>) {
    let groups = arguments.residuals.len();
    let mut first = 0;
    while first < groups {
        match groups - first {
            3.. if L::MANY_REGISTERS => {
                pass::<L, 3>(&mut arguments, first);
                first += 3;
            }
            2 if L::MANY_REGISTERS => {
                pass::<L, 2>(&mut arguments, first);
                first += 2;
            }
            _ => {
                pass::<L, 1>(&mut arguments, first);
                first += 1;
            }
        }
    }
}

/// Takes `G` groups from `first` on through the network and back.
#[inline(always)]
fn pass<L: Lanes, const G: usize>(arguments: &mut PassArguments<'_>, first: usize) {
    let PassArguments { weights, buffers, states, residuals, gradients } = arguments;
    let PassBuffers { heading, cosines, front, back } = &mut **buffers;
    let heading = heading.as_chunks_mut::<G>().0.split_at_mut(2).0;
    let front = front.as_chunks_mut::<G>().0;
    let back = back.as_chunks_mut::<G>().0;
    let (cos0, rest) = cosines.as_chunks_mut::<G>().0.split_at_mut(LAYER_WIDTHS[0]);
    let (cos1, rest) = rest.split_at_mut(LAYER_WIDTHS[1]);
    let (cos2, rest) = rest.split_at_mut(LAYER_WIDTHS[2]);
    let (cos3, rest) = rest.split_at_mut(LAYER_WIDTHS[3]);
    let (cos4, cos5) = rest.split_at_mut(LAYER_WIDTHS[4]);

    let states = states.map(|component| &component[first..first + G]);
    match &weights.layer0 {
        FirstLayer::Raw(layer) => {
            for component in 0..4 {
                back[component].copy_from_slice(states[component]);
            }
            forward::<L, G, 4, 48>(layer, back, front, cos0);
        }
        FirstLayer::HeadingCosSin(layer) => {
            for group in 0..G {
                let (sin, cos) = sin_cos(L::load(&states[2][group]));
                cos.store(&mut back[2][group]);
                sin.store(&mut back[3][group]);
            }
            for (input, component) in [(0, 0), (1, 1), (4, 3)] {
                back[input].copy_from_slice(states[component]);
            }
            heading.copy_from_slice(&back[2..4]);
            forward::<L, G, 5, 48>(layer, back, front, cos0);
        }
        FirstLayer::Position(layer) => {
            for component in 0..2 {
                back[component].copy_from_slice(states[component]);
            }
            forward::<L, G, 2, 48>(layer, back, front, cos0);
        }
    }
    forward::<L, G, 48, 48>(&weights.layer1, front, back, cos1);
    forward::<L, G, 48, 24>(&weights.layer2, back, front, cos2);
    forward::<L, G, 24, 24>(&weights.layer3, front, back, cos3);
    forward::<L, G, 24, 12>(&weights.layer4, back, front, cos4);
    forward::<L, G, 12, 12>(&weights.layer5, front, back, cos5);

    for group in 0..G {
        let mut y = L::splat(weights.output.bias[0]);
        for input in 0..12 {
            y = L::splat(weights.output.by_input[input][0]).mul_add(L::load(&back[input][group]), y);
        }
        let (residual, slope) = softplus_with_slope(y);
        residual.store(&mut residuals[first + group]);
        for input in 0..12 {
            slope.mul(L::splat(weights.output.by_input[input][0])).store(&mut front[input][group]);
        }
    }

    let Some(gradients) = gradients else { return };
    reverse::<L, G, 12, 12>(&weights.layer5, front, back, cos5);
    reverse::<L, G, 24, 12>(&weights.layer4, back, front, cos4);
    reverse::<L, G, 24, 24>(&weights.layer3, front, back, cos3);
    reverse::<L, G, 48, 24>(&weights.layer2, back, front, cos2);
    reverse::<L, G, 48, 48>(&weights.layer1, front, back, cos1);
    let gradients = gradients.each_mut().map(|component| &mut component[first..first + G]);
    match &weights.layer0 {
        FirstLayer::Raw(layer) => {
            reverse::<L, G, 4, 48>(layer, back, front, cos0);
            for (component, gradient) in gradients.into_iter().enumerate() {
                gradient.copy_from_slice(&front[component]);
            }
        }
        FirstLayer::HeadingCosSin(layer) => {
            reverse::<L, G, 5, 48>(layer, back, front, cos0);
            let [by_x, by_y, by_heading, by_speed] = gradients;
            by_x.copy_from_slice(&front[0]);
            by_y.copy_from_slice(&front[1]);
            by_speed.copy_from_slice(&front[4]);
            // ∂r/∂z₃ = cos z₃ · ∂r/∂(sin z₃) − sin z₃ · ∂r/∂(cos z₃)
            for group in 0..G {
                let (cos, sin) = (L::load(&heading[0][group]), L::load(&heading[1][group]));
                let by_cos = sin.mul(L::load(&front[2][group]));
                let by_sin = cos.mul(L::load(&front[3][group]));
                by_sin.sub(by_cos).store(&mut by_heading[group]);
            }
        }
        FirstLayer::Position(layer) => {
            reverse::<L, G, 2, 48>(layer, back, front, cos0);
            let [by_x, by_y, by_heading, by_speed] = gradients;
            by_x.copy_from_slice(&front[0]);
            by_y.copy_from_slice(&front[1]);
            by_heading.fill(Group::ZERO);
            by_speed.fill(Group::ZERO);
        }
    }
}

/// `a' = sin(W a + b)`, and keeps `cos(W a + b)` for the way back.
#[inline(always)]
fn forward<L: Lanes, const G: usize, const IN: usize, const OUT: usize>(
    layer: &Layer<IN, OUT>,
    input: &[[Group; G]],
    output: &mut [[Group; G]],
    cosines: &mut [[Group; G]],
) {
    product::<L, G, IN, OUT>(&layer.by_input, &layer.bias, input, output);
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
    by_output: &mut [[Group; G]],
    by_input: &mut [[Group; G]],
    cosines: &[[Group; G]],
) {
    for (by_output, cosine) in by_output[..OUT].iter_mut().zip(&cosines[..OUT]) {
        for group in 0..G {
            L::load(&by_output[group]).mul(L::load(&cosine[group])).store(&mut by_output[group]);
        }
    }
    product::<L, G, OUT, IN>(&layer.by_output, &[0.0; IN], by_output, by_input);
}

/// `y_n = start_n + Σ_k matrix_kn x_k`, blocked so that the accumulators fill the registers.
#[inline(always)]
fn product<L: Lanes, const G: usize, const K: usize, const N: usize>(
    matrix: &[[f32; N]; K],
    start: &[f32; N],
    x: &[[Group; G]],
    y: &mut [[Group; G]],
) {
    if L::MANY_REGISTERS && G == 1 && N.is_multiple_of(12) {
        product_in_blocks::<L, G, 12, K, N>(matrix, start, x, y);
    } else if N.is_multiple_of(4) {
        product_in_blocks::<L, G, 4, K, N>(matrix, start, x, y);
    } else {
        // The two or five inputs of another encoding than the paper's.
        product_in_blocks::<L, G, N, K, N>(matrix, start, x, y);
    }
}

#[inline(always)]
fn product_in_blocks<L: Lanes, const G: usize, const B: usize, const K: usize, const N: usize>(
    matrix: &[[f32; N]; K],
    start: &[f32; N],
    x: &[[Group; G]],
    y: &mut [[Group; G]],
) {
    let x = &x[..K];
    for block in 0..N / B {
        let mut sums = [[L::splat(0.0); G]; B];
        for row in 0..B {
            sums[row] = [L::splat(start[block * B + row]); G];
        }
        for k in 0..K {
            let weights = &matrix[k].as_chunks::<B>().0[block];
            let mut inputs = [L::splat(0.0); G];
            for group in 0..G {
                inputs[group] = L::load(&x[k][group]);
            }
            for row in 0..B {
                let weight = L::splat(weights[row]);
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
