// SPDX-License-Identifier: GPL-2.0-or-later
//! ethercrab-walk INTERFACE TYPE... - ethercrab on a line of simulated slaves: scan, distributed
//! clocks with SYNC0, OP, process data, a drive that moves. Prints what failed and, last, "N passed,
//! M failed".

use std::time::{Duration, Instant};

use ethercrab::error::Error;
use ethercrab::std::{ethercat_now, tx_rx_task};
use ethercrab::subdevice_group::{DcConfiguration, TxRxResponse};
use ethercrab::{
    DcSync, MainDevice, MainDeviceConfig, PduStorage, RegisterAddress, RetryBehaviour, Timeouts,
};

const MAX_SLAVES: usize = 16;
const MAX_IMAGE: usize = 512;
const CYCLE: Duration = Duration::from_millis(2);

static STORAGE: PduStorage<32, { PduStorage::element_size(1100) }> = PduStorage::new();

struct Expected {
    order: &'static str, // what ethercrab takes for the name
    name: &'static str,
    product: u32,
    outputs: usize,
    inputs: usize,
    drive: bool,
}

static DRIVE: Expected = Expected {
    order: "drive-cia402",
    name: "Simulated servo drive CiA 402",
    product: 0x0402_0001,
    outputs: 8,
    inputs: 20,
    drive: true,
};

static TERMINAL: Expected = Expected {
    order: "dio-8x8",
    name: "Simulated DIO 8 in 8 out",
    product: 0x00d1_0808,
    outputs: 1,
    inputs: 1,
    drive: false,
};

#[derive(Default)]
struct Score {
    passed: u32,
    failed: u32,
}

impl Score {
    fn check(&mut self, good: bool, what: impl std::fmt::Display) {
        if good {
            self.passed += 1;
        } else {
            self.failed += 1;
            println!("not ok  {what}");
        }
    }
}

fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

fn i32_at(bytes: &[u8], at: usize) -> i32 {
    i32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// Controlword that brings a drive one state further, 15 when it is enabled.
fn next_controlword(status: u16) -> u16 {
    match status & 0x6f {
        0x21 => 7,
        0x23 | 0x27 => 15,
        _ => 6,
    }
}

async fn walk(interface: &str, expected: &[&Expected], score: &mut Score) -> Result<(), Error> {
    let (tx, rx, pdu_loop) = STORAGE.try_split().expect("split once");
    let maindevice = MainDevice::new(
        pdu_loop,
        Timeouts {
            // Patience for a machine that does other things: nothing is lost on this bus.
            pdu: Duration::from_secs(2),
            eeprom: Duration::from_secs(5),
            wait_loop_delay: Duration::from_millis(1),
            mailbox_echo: Duration::from_secs(5),
            ..Timeouts::default()
        },
        MainDeviceConfig {
            retry_behaviour: RetryBehaviour::None,
            ..MainDeviceConfig::default()
        },
    );
    smol::spawn(tx_rx_task(interface, tx, rx).expect("no socket")).detach();

    let began = Instant::now();
    let mut group = maindevice
        .init_single_group::<MAX_SLAVES, MAX_IMAGE>(ethercat_now)
        .await?;
    println!(
        "scan and static clock alignment: {} ms",
        began.elapsed().as_millis()
    );
    score.check(
        group.len() == expected.len(),
        format!("{} slaves", group.len()),
    );
    for (i, (mut slave, e)) in group.iter_mut(&maindevice).zip(expected).enumerate() {
        let identity = slave.identity();
        score.check(
            slave.name() == e.order,
            format!("slave {i}: order {}", slave.name()),
        );
        score.check(
            identity.vendor_id == 0x5447_534d,
            format!("slave {i}: vendor"),
        );
        score.check(
            identity.product_id == e.product,
            format!("slave {i}: product"),
        );
        score.check(
            slave.configured_address() == 0x1000 + i as u16,
            format!("slave {i}: address"),
        );
        score.check(
            slave
                .description()
                .await?
                .is_some_and(|d| d.as_str() == e.name),
            format!("slave {i}: description"),
        );
        if !e.drive {
            continue;
        }
        slave.set_dc_sync(DcSync::Sync0);
        // ethercrab measures between neighbours; a terminal without a clock has no times to give.
        score.check(
            slave.propagation_delay() > 0 || i == 0 || !expected[i - 1].drive,
            format!("slave {i}: propagation delay {}", slave.propagation_delay()),
        );
        score.check(
            slave.sdo_read::<u32>(0x1018, 2).await? == e.product,
            format!("slave {i}: product by SDO"),
        );
        slave.sdo_write(0x6081, 0, 654_321u32).await?;
        score.check(
            slave.sdo_read::<u32>(0x6081, 0).await? == 654_321,
            format!("slave {i}: a value written and read back"),
        );
        score.check(
            matches!(
                slave.sdo_read::<u32>(0x5fff, 0).await,
                Err(Error::Mailbox(_))
            ),
            format!("slave {i}: a missing object is aborted"),
        );
        let list = slave
            .sdo_info_object_description_list(ethercrab::ObjectDescriptionListQuery::All)
            .await?;
        score.check(
            list.is_some_and(|list| list.len() >= 40 && list.contains(&0x6040)),
            format!("slave {i}: object list"),
        );
    }

    let group = group.into_pre_op_pdi(&maindevice).await?;
    let began = Instant::now();
    let mut furthest = u32::MAX;
    for cycle in 1.. {
        group.tx_rx_sync_system_time(&maindevice).await?;
        smol::Timer::after(CYCLE / 2).await;
        if cycle % 50 != 0 {
            continue;
        }
        furthest = 0;
        for (slave, e) in group.iter(&maindevice).zip(expected).skip(1) {
            if e.drive {
                let raw = slave
                    .register_read::<u32>(RegisterAddress::DcSystemTimeDifference)
                    .await?;
                furthest = furthest.max(raw & 0x7fff_ffff);
            }
        }
        if furthest < 1000 || began.elapsed() > Duration::from_secs(10) {
            break;
        }
    }
    println!(
        "clocks: {furthest} ns after {} ms",
        began.elapsed().as_millis()
    );
    score.check(furthest < 1000, format!("a clock stays {furthest} ns off"));
    let group = group
        .configure_dc_sync(
            &maindevice,
            DcConfiguration {
                start_delay: Duration::from_millis(100),
                sync0_period: CYCLE,
                sync0_shift: CYCLE / 2,
            },
        )
        .await?;
    let group = group.into_safe_op(&maindevice).await?;
    for (i, (slave, e)) in group.iter(&maindevice).zip(expected).enumerate() {
        score.check(
            slave.outputs_raw().len() == e.outputs,
            format!("slave {i}: outputs"),
        );
        score.check(
            slave.inputs_raw().len() == e.inputs,
            format!("slave {i}: inputs"),
        );
    }
    let group = group.request_into_op(&maindevice).await?;
    let began = Instant::now();
    loop {
        let now = Instant::now();
        let response = group.tx_rx_dc(&maindevice).await?;
        if response.all_op() {
            break;
        }
        if began.elapsed() > Duration::from_secs(5) {
            score.check(false, "OP");
            for (i, slave) in group.iter(&maindevice).enumerate() {
                println!("not ok  slave {i}: {:?}", slave.status().await?);
            }
            return Ok(());
        }
        smol::Timer::at(now + response.extra.next_cycle_wait).await;
    }
    score.check(true, "OP");

    let wanted = 3 * expected.len() as u16;
    let mut short = 0;
    let mut begin = vec![None; expected.len()];
    let mut target = vec![0i32; expected.len()];
    let mut moving = 0;
    let mut last_time = 0;
    for cycle in 0..1000u32 {
        let now = Instant::now();
        let TxRxResponse {
            working_counter,
            extra,
            ..
        } = group.tx_rx_dc(&maindevice).await?;
        if working_counter != wanted {
            short += 1;
        }
        if extra.dc_system_time <= last_time {
            score.check(false, format!("cycle {cycle}: the reference clock goes"));
        }
        last_time = extra.dc_system_time;
        let mut all_enabled = true;
        for (i, (slave, e)) in group.iter(&maindevice).zip(expected).enumerate() {
            let mut io = slave.io_raw_mut();
            let (inputs, outputs) = {
                let inputs = io.inputs().to_vec();
                (inputs, io.outputs())
            };
            if !e.drive {
                outputs[0] = cycle as u8;
                continue;
            }
            let (status, actual) = (u16_at(&inputs, 0), i32_at(&inputs, 4));
            if status & 0x6f != 0x27 {
                all_enabled = false;
                target[i] = actual;
            } else {
                begin[i].get_or_insert(actual);
            }
            if moving > 0 && moving <= 400 {
                target[i] += 700;
            }
            outputs[0..2].copy_from_slice(&next_controlword(status).to_le_bytes());
            outputs[2] = 8;
            outputs[4..8].copy_from_slice(&target[i].to_le_bytes());
        }
        if all_enabled {
            moving += 1;
        }
        smol::Timer::at(now + extra.next_cycle_wait).await;
    }
    score.check(moving > 500, format!("drives enabled for {moving} cycles"));
    score.check(short == 0, format!("{short} working counters short"));
    for (i, (slave, e)) in group.iter(&maindevice).zip(expected).enumerate() {
        let io = slave.inputs_raw();
        if e.drive {
            let travelled = i32_at(&io, 4).wrapping_sub(begin[i].unwrap_or(0));
            score.check(
                (travelled - 400 * 700).abs() < 300,
                format!("slave {i}: travelled {travelled}"),
            );
        } else {
            score.check(io[0] & 0xfe == 0, format!("slave {i}: inputs"));
        }
    }
    let group = group.into_safe_op(&maindevice).await?;
    let group = group.into_pre_op(&maindevice).await?;
    group.into_init(&maindevice).await?;
    Ok(())
}

fn main() {
    let mut words = std::env::args().skip(1);
    let interface = words.next().expect("interface");
    let expected: Vec<&Expected> = words
        .map(|word| match word.as_str() {
            order if order == DRIVE.order => &DRIVE,
            order if order == TERMINAL.order => &TERMINAL,
            other => panic!("no type {other}"),
        })
        .collect();
    let mut score = Score::default();
    if let Err(error) = smol::block_on(walk(&interface, &expected, &mut score)) {
        score.check(false, format!("{error:?}"));
    }
    println!("{} passed, {} failed", score.passed, score.failed);
    std::process::exit(i32::from(score.failed != 0));
}
