//! Latency histograms and the per-hop ledger.
