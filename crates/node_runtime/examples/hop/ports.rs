//! The ports of this crate, over either transport.

use std::time::Duration;

use messages::ProcessId;
use node_runtime::{Domain, Node, Publisher, Subscriber, Transport, WakeUp, Waker};

use crate::{
    Failure,
    message::{Hop, Receiving, Sending},
};

const INSTANCE: &str = "hop";

pub(crate) struct Sender {
    publisher: Publisher<Hop>,
    waker: Waker,
    _node: Node,
}

pub(crate) struct Receiver {
    subscriber: Subscriber<Hop>,
    wake_up: WakeUp,
    _node: Node,
}

impl Sender {
    pub(crate) fn new(transport: Transport, domain: &Domain) -> Result<Self, Failure> {
        let node = Node::open_over(transport, domain, INSTANCE, ProcessId::Estimator)?;
        Ok(Self { publisher: node.publisher()?, waker: node.waker(ProcessId::Filter)?, _node: node })
    }
}

impl Receiver {
    pub(crate) fn new(transport: Transport, domain: &Domain) -> Result<Self, Failure> {
        let node = Node::open_over(transport, domain, INSTANCE, ProcessId::Filter)?;
        Ok(Self { subscriber: node.subscriber()?, wake_up: node.wake_up()?, _node: node })
    }
}

impl Sending for Sender {
    fn send(&mut self, message: &Hop) -> Result<(), Failure> {
        self.publisher.send(message)?;
        self.waker.wake();
        Ok(())
    }
}

impl Receiving for Receiver {
    fn wait(&mut self) -> Result<Option<Hop>, Failure> {
        self.wake_up.wait(Duration::from_secs(1));
        Ok(self.subscriber.newest())
    }
}
