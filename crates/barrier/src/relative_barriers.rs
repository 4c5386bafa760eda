//! Several models at once: each obstacle is evaluated by the model that holds for it. Not here: one model
//! (`relative_barrier`), and what becomes of the values (`composite`).

use crate::MAX_OBSTACLES;
use crate::kernel::{Kernel, KernelError};
use crate::model::Model;
use crate::relative_barrier::{RelativeBarrier, RelativeObstacle, RelativeSample};

/// Relative barriers of one robot against different kinds of obstacles. Holds every buffer it needs.
pub(crate) struct RelativeBarriers {
    models: Vec<RelativeBarrier>,
    /// The obstacles of one model side by side, what became of them, and where they came from.
    gathered: Vec<RelativeObstacle>,
    samples: Vec<RelativeSample>,
    origins: Vec<usize>,
}

impl RelativeBarriers {
    pub(crate) fn new(model: &Model, kernel: Kernel) -> Result<Self, KernelError> {
        Ok(Self {
            models: vec![RelativeBarrier::new(model, kernel)?],
            gathered: Vec::with_capacity(MAX_OBSTACLES),
            samples: Vec::with_capacity(MAX_OBSTACLES),
            origins: Vec::with_capacity(MAX_OBSTACLES),
        })
    }

    /// Adds a model and returns its index.
    pub(crate) fn add(&mut self, model: &Model) -> Result<usize, KernelError> {
        self.models.push(RelativeBarrier::new(model, self.kernel())?);
        Ok(self.models.len() - 1)
    }

    pub(crate) fn kernel(&self) -> Kernel {
        self.models[0].kernel()
    }

    pub(crate) fn count(&self) -> usize {
        self.models.len()
    }

    /// Computes `samples[i]` for `obstacles[i]` by model `model_of(i)`, which exists; without gradients on wish.
    pub(crate) fn evaluate<const GRADIENT: bool>(
        &mut self,
        obstacles: &[RelativeObstacle],
        model_of: impl Fn(usize) -> usize,
        samples: &mut [RelativeSample],
    ) {
        if let [only] = self.models.as_mut_slice() {
            return run::<GRADIENT>(only, obstacles, samples);
        }
        for (index, model) in self.models.iter_mut().enumerate() {
            self.origins.clear();
            self.origins.extend((0..obstacles.len()).filter(|&origin| model_of(origin) == index));
            self.gathered.clear();
            self.gathered.extend(self.origins.iter().map(|&origin| obstacles[origin]));
            self.samples.resize(self.gathered.len(), RelativeSample::default());
            run::<GRADIENT>(model, &self.gathered, &mut self.samples);
            for (&origin, sample) in self.origins.iter().zip(&self.samples) {
                samples[origin] = *sample;
            }
        }
    }
}

fn run<const GRADIENT: bool>(
    model: &mut RelativeBarrier,
    obstacles: &[RelativeObstacle],
    samples: &mut [RelativeSample],
) {
    if GRADIENT {
        model.evaluate(obstacles, samples);
    } else {
        model.evaluate_values(obstacles, samples);
    }
}
