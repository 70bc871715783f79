//! The search for the smallest table that meets a tolerance: nodes are put in where they lower the
//! error most for their bytes, then every node and product that is not needed is taken out.
//!
//! Every trial is the table itself: fitted, stored in 16 bits, read by the runtime and compared with
//! skies that it was not fitted to. Deterministic: trials run side by side, choices are made in order.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context as _, Result};
use rayon::prelude::*;
use sky_core::conditions::Domain;
use sky_core::extended::{TERM_NAMES, TERMS};
use sky_core::lut::{Lut, LutHeader, Storage};
use sky_core::utm_sky::MAX_LAYERS;
use sky_core::utm_sky::UtmSky;
use sky_eval::score::{Case, Score, score_of};
use sky_fit::sweep::fit_turbidity;

use crate::scene::Tolerance;
use crate::space::{Lattice, axes, by_altitude, candidates, coarsest, middle, ranges};

/// Names and units of the axes, in the table's order.
pub(crate) const AXES: [(&str, &str); 3] = [
    ("altitude", " km"),
    ("turbidity", ""),
    ("sun zenith", " deg"),
];

/// Solved turbidities that are kept.
const KEPT: usize = 512;

/// Tables beyond this are not tried.
const MAX_BYTES: usize = 1 << 20;

/// Nodes and products of a table.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Choice {
    /// Nodes of altitude, turbidity and sun zenith.
    pub(crate) nodes: [Vec<f64>; 3],
    /// Places of the products.
    pub(crate) terms: Vec<usize>,
    /// How values are stored.
    pub(crate) storage: Storage,
}

/// A step from one choice to a neighbor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Edit {
    /// Puts a node in; into an axis of one node both ends instead of it.
    Insert(usize, f64),
    /// Takes an inner node out.
    Remove(usize, f64),
    /// One node in the middle for two at the ends.
    Collapse(usize),
    /// Moves an inner node.
    Move(usize, f64, f64),
    /// Takes a product out.
    Drop(usize),
}

impl Edit {
    /// What it does, for people.
    pub(crate) fn words(self) -> String {
        let node = |axis: usize, value: f64| format!("{} {value}{}", AXES[axis].0, AXES[axis].1);
        match self {
            Self::Insert(axis, value) => format!("node at {}", node(axis, value)),
            Self::Remove(axis, value) => format!("without the node at {}", node(axis, value)),
            Self::Collapse(axis) => format!("no interpolation in {}", AXES[axis].0),
            Self::Move(axis, from, to) => format!("{from} for {}", node(axis, to)),
            Self::Drop(term) => format!("without the product {}", TERM_NAMES[term]),
        }
    }
}

/// A choice and what it is worth.
#[derive(Clone, Debug)]
pub(crate) struct Trial {
    pub(crate) choice: Choice,
    pub(crate) score: Score,
    /// The larger of both errors over what is aimed at: 1 and below is good.
    pub(crate) ratio: f64,
    /// Bytes of the file.
    pub(crate) bytes: usize,
}

type Key = Vec<u64>;

/// What edits lead to.
pub(crate) type Neighbors = Vec<(Edit, Trial)>;

/// Everything that trials need.
pub(crate) struct Search<'a> {
    pub(crate) lattice: Lattice<'a>,
    pub(crate) cases: &'a [Case],
    pub(crate) domain: Domain,
    pub(crate) aim: Tolerance,
    /// Header of the table; axes and terms are those of the choice.
    pub(crate) header: LutHeader,
    candidates: [Vec<f64>; 3],
    solved: Mutex<BTreeMap<Key, Arc<Vec<f64>>>>,
    /// Told of every trial.
    pub(crate) done: &'a (dyn Fn() + Sync),
}

impl<'a> Search<'a> {
    pub(crate) fn new(
        lattice: Lattice<'a>,
        cases: &'a [Case],
        domain: Domain,
        aim: Tolerance,
        header: LutHeader,
        done: &'a (dyn Fn() + Sync),
    ) -> Self {
        Self {
            lattice,
            cases,
            domain,
            aim,
            header,
            candidates: candidates(&domain),
            solved: Mutex::new(BTreeMap::new()),
            done,
        }
    }

    /// The values at a turbidity, from memory where they were fitted before.
    fn values_at(&self, turbidity: f64, choice: &Choice) -> Result<Arc<Vec<f64>>> {
        let [altitude, _, sun] = &choice.nodes;
        let bits = |nodes: &[f64]| nodes.iter().map(|n| n.to_bits()).collect::<Vec<_>>();
        let key = [
            vec![turbidity.to_bits(), altitude.len() as u64],
            bits(altitude),
            bits(sun),
            choice.terms.iter().map(|t| *t as u64).collect(),
        ]
        .concat();
        let lock = || self.solved.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = lock().get(&key) {
            return Ok(Arc::clone(known));
        }
        let [altitude, _, sun] = axes(choice.nodes.clone())?;
        let equations = &self.lattice.layer(turbidity)?.equations;
        let made = Arc::new(fit_turbidity(equations, &altitude, &sun, &choice.terms)?);
        let mut solved = lock();
        if solved.len() >= KEPT {
            solved.clear();
        }
        solved.insert(key, Arc::clone(&made));
        Ok(made)
    }

    /// The table of a choice, whose turbidities were prepared.
    pub(crate) fn lut(&self, choice: &Choice) -> Result<Lut> {
        let [altitude, turbidity, _] = &choice.nodes;
        let fits: Vec<Arc<Vec<f64>>> = turbidity
            .par_iter()
            .map(|t| self.values_at(*t, choice))
            .collect::<Result<_>>()?;
        let fits: Vec<&[f64]> = fits.iter().map(|fit| fit.as_slice()).collect();
        let values = by_altitude(&fits, altitude.len());
        let [altitude_km, turbidity, sun_zenith_deg] = axes(choice.nodes.clone())?;
        let header = LutHeader {
            altitude_km,
            turbidity,
            sun_zenith_deg,
            storage: choice.storage,
            terms: choice
                .terms
                .iter()
                .map(|t| TERM_NAMES[*t].to_owned())
                .collect(),
            ..self.header.clone()
        };
        Ok(Lut::from_f64(header, &values)?)
    }

    /// Measures a choice whose turbidities were prepared.
    fn measured(&self, choice: Choice) -> Result<Trial> {
        let sky = UtmSky::new(self.lut(&choice)?)?;
        let score = score_of(&sky, self.cases)?;
        (self.done)();
        Ok(Trial {
            ratio: self.ratio(&score),
            bytes: sky.lut().encode().len(),
            score,
            choice,
        })
    }

    /// Measures a choice.
    pub(crate) fn trial(&mut self, choice: Choice) -> Result<Trial> {
        self.lattice.prepare(&choice.nodes[1])?;
        self.measured(choice)
    }

    /// The larger of both errors over what is aimed at.
    pub(crate) fn ratio(&self, score: &Score) -> f64 {
        let color = score.delta_e.p95 / self.aim.delta_e;
        color.max(score.luminance.p95 / self.aim.luminance)
    }

    /// A choice after an edit; `None` where the edit does not suit it.
    pub(crate) fn edited(&self, choice: &Choice, edit: Edit) -> Option<Choice> {
        let mut new = choice.clone();
        match edit {
            Edit::Insert(axis, value) => {
                let nodes = &mut new.nodes[axis];
                if nodes.len() == 1 {
                    let [low, high] = ranges(&self.domain)[axis];
                    if high <= low {
                        return None;
                    }
                    *nodes = vec![low, high];
                } else {
                    let at = nodes.partition_point(|n| *n < value);
                    nodes.insert(at, value);
                }
            }
            Edit::Remove(axis, value) => {
                let at = new.nodes[axis]
                    .iter()
                    .position(|n| n.total_cmp(&value).is_eq())?;
                if at == 0 || at + 1 == new.nodes[axis].len() {
                    return None;
                }
                new.nodes[axis].remove(at);
            }
            Edit::Collapse(axis) => {
                if new.nodes[axis].len() != 2 {
                    return None;
                }
                new.nodes[axis] = vec![middle(axis, ranges(&self.domain)[axis])];
            }
            Edit::Move(axis, from, to) => {
                let at = new.nodes[axis]
                    .iter()
                    .position(|n| n.total_cmp(&from).is_eq())?;
                new.nodes[axis][at] = to;
                if !new.nodes[axis].is_sorted_by(|a, b| a < b) {
                    return None;
                }
            }
            Edit::Drop(term) => {
                new.terms.retain(|t| *t != term);
                if new.terms.is_empty() || new.terms.len() == choice.terms.len() {
                    return None;
                }
            }
        }
        Some(new)
    }

    /// Candidates between two values of an axis.
    fn between(&self, axis: usize, low: f64, high: f64) -> Vec<f64> {
        let inside = self.candidates[axis]
            .iter()
            .filter(|c| **c > low && **c < high);
        inside.copied().collect()
    }

    fn insertions(&self, choice: &Choice) -> Vec<Edit> {
        let mut edits = Vec::new();
        for (axis, nodes) in choice.nodes.iter().enumerate() {
            if nodes.len() == 1 {
                edits.push(Edit::Insert(axis, nodes[0]));
            }
            if axis == 0 && nodes.len() >= MAX_LAYERS {
                continue;
            }
            for pair in nodes.windows(2) {
                let inside = self.between(axis, pair[0], pair[1]);
                if let Some(middle) = inside.get(inside.len() / 2) {
                    edits.push(Edit::Insert(axis, *middle));
                }
            }
        }
        edits
    }

    /// Moves of the inner nodes to the next candidates.
    fn moves(&self, choice: &Choice) -> Vec<Edit> {
        let mut edits = Vec::new();
        for (axis, nodes) in choice.nodes.iter().enumerate() {
            for three in nodes.windows(3) {
                let below = self.between(axis, three[0], three[1]);
                let above = self.between(axis, three[1], three[2]);
                for to in below.last().into_iter().chain(above.first()) {
                    edits.push(Edit::Move(axis, three[1], *to));
                }
            }
        }
        edits
    }

    /// Everything that can be taken out of a choice.
    pub(crate) fn removals(&self, choice: &Choice) -> Vec<Edit> {
        let mut edits = Vec::new();
        for (axis, nodes) in choice.nodes.iter().enumerate() {
            if nodes.len() == 2 {
                edits.push(Edit::Collapse(axis));
            }
            if let [_, inner @ .., _] = nodes.as_slice() {
                edits.extend(inner.iter().map(|n| Edit::Remove(axis, *n)));
            }
        }
        edits.extend(choice.terms.iter().map(|t| Edit::Drop(*t)));
        edits
    }

    /// Measures what edits lead to, in their order.
    pub(crate) fn trials(&mut self, choice: &Choice, edits: &[Edit]) -> Result<Neighbors> {
        let choices: Vec<(Edit, Choice)> = edits
            .iter()
            .filter_map(|edit| Some((*edit, self.edited(choice, *edit)?)))
            .collect();
        for (_, choice) in &choices {
            self.lattice.prepare(&choice.nodes[1])?;
        }
        let this = &*self;
        choices
            .into_par_iter()
            .map(|(edit, choice)| Ok((edit, this.measured(choice)?)))
            .collect()
    }

    /// Puts nodes in until the ratio is at most `goal`; the last trial, whether it is or not.
    pub(crate) fn grow(&mut self, from: Trial, goal: f64) -> Result<Trial> {
        let mut current = from;
        while current.ratio > goal {
            let edits = self.insertions(&current.choice);
            let trials = self.trials(&current.choice, &edits)?;
            // what is gained for the bytes, both as logarithms
            let worth = |t: &Trial| {
                let gain = (current.ratio / t.ratio).ln();
                let price = (t.bytes as f64 / current.bytes as f64).ln();
                gain / price.max(1e-6)
            };
            let best = trials
                .into_iter()
                .filter(|(_, t)| t.bytes <= MAX_BYTES)
                .max_by(|(_, a), (_, b)| worth(a).total_cmp(&worth(b)));
            match best {
                Some((_, best)) => current = best,
                None => break,
            }
        }
        Ok(current)
    }

    /// Moves nodes as long as that lowers the error by a percent, at most a few times.
    pub(crate) fn settle(&mut self, from: Trial) -> Result<Trial> {
        let mut current = from;
        for _ in 0..3 {
            let edits = self.moves(&current.choice);
            let trials = self.trials(&current.choice, &edits)?;
            let best = trials
                .into_iter()
                .min_by(|(_, a), (_, b)| a.ratio.total_cmp(&b.ratio));
            match best {
                Some((_, best)) if best.ratio < 0.99 * current.ratio => current = best,
                _ => break,
            }
        }
        Ok(current)
    }

    /// Takes out what is not needed. The result, and what each further removal would lead to: all
    /// of them break the aim.
    pub(crate) fn prune(&mut self, from: Trial) -> Result<(Trial, Neighbors)> {
        let mut current = from;
        loop {
            let edits = self.removals(&current.choice);
            let trials = self.trials(&current.choice, &edits)?;
            let price = |t: &Trial| {
                let saved = (current.bytes as f64 / t.bytes as f64).ln();
                (t.ratio / current.ratio).ln() / saved.max(1e-6)
            };
            let mut good: Vec<(f64, Edit)> = trials
                .iter()
                .filter(|(_, t)| t.ratio <= 1.0 && t.bytes <= current.bytes)
                .map(|(edit, t)| (price(t), *edit))
                .collect();
            if good.is_empty() {
                return Ok((current, trials));
            }
            good.sort_by(|(a, _), (b, _)| a.total_cmp(b));
            // the cheapest removals of this round one after the other, measured together
            let mut failures = 0;
            for (_, edit) in good {
                let Some(choice) = self.edited(&current.choice, edit) else {
                    continue;
                };
                let trial = self.trial(choice)?;
                if trial.ratio <= 1.0 {
                    current = trial;
                } else {
                    failures += 1;
                    if failures == 2 {
                        break;
                    }
                }
            }
        }
    }

    /// The coarsest choice: one node an axis, every product.
    pub(crate) fn start(&self) -> Choice {
        Choice {
            nodes: coarsest(&self.domain),
            terms: (0..TERMS).collect(),
            storage: Storage::Linear16,
        }
    }

    /// The smallest table that was found, and what breaks it; the trial that came closest where the
    /// aim was not met.
    pub(crate) fn run(&mut self) -> Result<(Trial, Option<Neighbors>)> {
        let start = self.start();
        let mut grown = self.trial(start)?;
        let mut best: Option<(Trial, Neighbors)> = None;
        // nodes to spare let products go
        for goal in [1.0, 0.8] {
            grown = self.grow(grown, goal)?;
            grown = self.settle(grown)?;
            if grown.ratio > 1.0 {
                break;
            }
            let pruned = self.prune(grown.clone())?;
            if best.as_ref().is_none_or(|(b, _)| pruned.0.bytes < b.bytes) {
                best = Some(pruned);
            }
        }
        Ok(best.map_or((grown, None), |(trial, broken)| (trial, Some(broken))))
    }
}

/// Names of products.
pub(crate) fn term_names(terms: &[usize]) -> Result<Vec<String>> {
    terms
        .iter()
        .map(|t| Ok((*TERM_NAMES.get(*t).context("a product of the formula")?).to_owned()))
        .collect()
}
