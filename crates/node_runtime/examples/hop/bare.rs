//! iceoryx2 as its own examples use it, with nothing of this project in between.

use std::time::Duration;

use iceoryx2::{
    config::Config,
    node::{Node, NodeBuilder},
    port::{listener::Listener, notifier::Notifier, publisher::Publisher, subscriber::Subscriber},
    service::{ipc::Service, port_factory},
};
use iceoryx2_bb_container::semantic_string::SemanticString;
use iceoryx2_bb_system_types::file_name::FileName;

use crate::{
    Failure,
    message::{Hop, Receiving, Sending},
};

type Data = port_factory::publish_subscribe::PortFactory<Service, Hop, ()>;
type Event = port_factory::event::PortFactory<Service>;

pub(crate) struct Sender {
    publisher: Publisher<Service, Hop, ()>,
    notifier: Notifier<Service>,
    _node: Node<Service>,
}

pub(crate) struct Receiver {
    subscriber: Subscriber<Service, Hop, ()>,
    listener: Listener<Service>,
    _node: Node<Service>,
}

impl Sender {
    pub(crate) fn new(prefix: &str) -> Result<Self, Failure> {
        let (node, data, event) = open(prefix)?;
        let (publisher, notifier) = (data.publisher_builder().create()?, event.notifier_builder().create()?);
        Ok(Self { publisher, notifier, _node: node })
    }
}

impl Receiver {
    pub(crate) fn new(prefix: &str) -> Result<Self, Failure> {
        let (node, data, event) = open(prefix)?;
        let (subscriber, listener) =
            (data.subscriber_builder().create()?, event.listener_builder().create()?);
        Ok(Self { subscriber, listener, _node: node })
    }
}

fn open(prefix: &str) -> Result<(Node<Service>, Data, Event), Failure> {
    let mut config = Config::default();
    config.global.prefix = FileName::new(prefix.as_bytes())?;
    let node = NodeBuilder::new().config(&config).create::<Service>()?;
    let data = node.service_builder(&"bare/data".try_into()?).publish_subscribe::<Hop>().open_or_create()?;
    let event = node.service_builder(&"bare/event".try_into()?).event().open_or_create()?;
    Ok((node, data, event))
}

impl Sending for Sender {
    fn send(&mut self, message: &Hop) -> Result<(), Failure> {
        self.publisher.loan_uninit()?.write_payload(*message).send()?;
        self.notifier.notify()?;
        Ok(())
    }
}

impl Receiving for Receiver {
    fn wait(&mut self) -> Result<Option<Hop>, Failure> {
        self.listener.timed_wait(|_| {}, Duration::from_secs(1))?;
        let mut newest = None;
        while let Some(sample) = self.subscriber.receive()? {
            newest = Some(*sample);
        }
        Ok(newest)
    }
}
