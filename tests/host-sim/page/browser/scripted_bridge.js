// A bridge that says what a test wants: the server of Foxglove's own library before the page as host-sim ships it. The
// test changes `state` and `bridge`, which are told at once, and `answers`; what the page has asked is in `asked`.
'use strict';

const { FoxgloveServer } = require('@foxglove/ws-protocol');
const { WebSocketServer } = require('ws');
const http = require('node:http');

const json = (value) => new TextEncoder().encode(JSON.stringify(value));
// As a bridge: the page takes one that is silent for longer for gone.
const heartbeat_ms = 250;
const services = [
  'describe',
  'history',
  'explain',
  'take_control',
  'release_control',
  'stop',
  'scan',
  'enable',
  'disable',
  'reset_faults',
  'mode',
  'target',
  'try',
  'commit',
  'revert',
  'store',
  'dump',
  'diff',
  'restore',
  'step',
  'record',
  'export',
  'choose',
];

const si = (unit) => ({ unit, factor: 1, offset: 0 });
/** Units of parameters: of a temperature degrees Celsius as well, of a difference not. */
const kinds = {
  W: [si('W'), { unit: 'mW', factor: 1e-3, offset: 0 }],
  A: [si('A'), { unit: 'mA', factor: 1e-3, offset: 0 }],
  K: [si('K'), { unit: 'degC', factor: 1, offset: 273.15 }],
  'limits.hot_spot_K': [si('K')],
};

/** What a servo that is off, healthy and alone has its bridge say. */
function usual() {
  return {
    client: 7,
    parameters: {
      'strain.proportional_W': 2,
      'limits.current_A': 0.4,
      'limits.temperature_K': 393.15,
      'limits.hot_spot_K': 18,
      'trajectory.feed_forward_s': 0.01,
      'axis.zero_strain': 0.04,
      'wire.length_m': 0.1,
    },
    description: {
      version: 'scripted',
      parameters: [
        ['strain.proportional_W', 'W', 0, 100],
        ['limits.current_A', 'A', 0, 20],
        ['limits.temperature_K', 'K', 273.15, 600],
        ['limits.hot_spot_K', 'K', 0, 100],
      ].map(([name, unit, min, max]) => ({
        name,
        type: 'number',
        unit,
        units: kinds[name] ?? kinds[unit],
        min,
        max,
        default: 1,
        change: 'live',
        level: 'tune',
        meaning: `what ${name} is`,
      })),
      signals: ['strain', 'wire_temperature_K', 'drive_current_A', 'power_W', 'position_m'].map((name) => ({
        name,
        unit: '',
        meaning: name,
      })),
      faults: [
        { name: 'wire_open', code: 'FF20h', class: 'F1', text: 'No current flows.' },
        { name: 'over_temperature', code: '4310h', class: 'F1', text: 'Too hot.' },
        { name: 'heat_limit', code: 'FF2Eh', class: 'L', text: 'The heat is limited.' },
      ],
      modes: [
        { mode: 0, name: 'none', unit: '' },
        { mode: 1, name: 'profile position', unit: 'um' },
      ],
    },
    bridge: {
      bus: 'can0',
      read_only: false,
      nodes: [{ node: 1, name: 'smaservo', online: true, duplicate: false }],
      control: null,
      clients: [{ client: 7, address: '127.0.0.1', queued: 0, dropped: 0, read_only: false }],
      activity: null,
      recordings: [],
      trouble: '',
    },
    state: {
      node: 1,
      online: true,
      nmt: 'operational',
      drive: 'switch_on_disabled',
      statusword: 0x240,
      mode: 1,
      mode_name: 'profile position',
      target: 0,
      position_um: 0,
      target_reached: true,
      active: [],
      latched: [],
      warnings: [],
      blocking: [],
      first_cause: null,
      limits: [],
      freeze_frame: null,
      transaction: { state: 'none', seconds_left: null },
      unsaved: false,
      rate_hz: 50,
      gaps: 0,
    },
    answers: {},
  };
}

class ScriptedBridge {
  /** On a free port, until close(). */
  static async start(page) {
    const bridge = new ScriptedBridge();
    bridge.http = http.createServer((_request, answer) => {
      answer.setHeader('Content-Type', 'text/html; charset=utf-8');
      answer.end(page);
    });
    bridge.sockets = new WebSocketServer({
      server: bridge.http,
      handleProtocols: () => FoxgloveServer.SUPPORTED_SUBPROTOCOL,
    });
    bridge.sockets.on('connection', (socket) => bridge.server.handleConnection(socket, 'page'));
    await new Promise((done) => bridge.http.listen(0, '127.0.0.1', done));
    bridge.url = `http://127.0.0.1:${bridge.http.address().port}/`;
    bridge.timer = setInterval(() => bridge.tell(), heartbeat_ms);
    bridge.begin({});
    return bridge;
  }

  /** Everything as usual but for what `said` changes, for those who connect from now on; `units` is their first
   * choice. */
  begin(said, units = 'bench') {
    clearInterval(this.streaming);
    this.drop();
    Object.assign(this, usual());
    Object.assign(this.bridge, said);
    this.asked = [];
    this.server = new FoxgloveServer({
      name: 'scripted',
      capabilities: ['parameters', 'parametersSubscribe', 'services'],
      supportedEncodings: ['json'],
      metadata: {
        version: 'scripted',
        client: String(this.client),
        read_only: String(this.bridge.read_only),
        units,
      },
    });
    this.channels = new Map(
      ['/bridge', ...this.bridge.nodes.flatMap(({ node }) => [`/node${node}/live`, `/node${node}/state`])].map(
        (topic) => [topic, this.server.addChannel({ topic, encoding: 'json', schemaName: topic, schema: '{}' })],
      ),
    );
    for (const name of services) {
      this.server.addService({ name, type: name, requestSchema: '{}', responseSchema: '{}' });
    }
    this.server.on('serviceCallRequest', (request, socket) => void this.call(request, socket));
    this.server.on('getParameters', ({ id }, socket) => this.server.publishParameterValues(this.values(), id, socket));
    this.server.on('setParameters', ({ parameters, id }, socket) => {
      this.asked.push(['set', parameters]);
      for (const { name, value } of parameters) {
        this.parameters[name.slice('node1.'.length)] = value;
      }
      this.server.publishParameterValues(this.values(), id, socket);
    });
    this.server.on('subscribe', () => this.tell());
  }

  values() {
    return Object.entries(this.parameters).map(([name, value]) => ({ name: `node1.${name}`, value }));
  }

  async call({ serviceId, callId, data }, socket) {
    const name = services[serviceId - 1];
    const request = JSON.parse(new TextDecoder().decode(data));
    this.asked.push([name, request]);
    try {
      const known = { describe: this.description, history: { t_ns: [] }, explain: { text: 'why it came' } };
      const answer = json((await this.answers[name]?.(request)) ?? known[name] ?? {});
      this.server.sendServiceCallResponse(
        { serviceId, callId, encoding: 'json', data: new DataView(answer.buffer) },
        socket,
      );
    } catch ({ message }) {
      this.server.sendServiceCallFailure({ op: 'serviceCallFailure', serviceId, callId, message }, socket);
    }
  }

  /** What the page has asked of a service, but not what it reads by itself. */
  requests(name) {
    return this.asked.filter(([asked]) => asked === name).map(([, request]) => request);
  }

  tell() {
    this.send('/bridge', this.bridge);
    this.send(`/node${this.state.node}/state`, this.state);
  }

  send(topic, value, time_ms = Date.now()) {
    const channel = this.channels.get(topic);
    if (channel !== undefined) {
      this.server.sendMessage(channel, BigInt(Math.round(time_ms * 1e3)) * 1000n, json(value));
    }
  }

  /** Samples of a strain that falls, `seconds` long, the last one now. */
  samples(seconds, rate_Hz = 50) {
    const count = seconds * rate_Hz;
    const now_ms = Date.now();
    for (let k = 0; k < count; ++k) {
      this.send(
        '/node1/live',
        {
          strain: 0.04 - (0.02 * k) / count,
          wire_temperature_K: 300 + (50 * k) / count,
          drive_current_A: 0.2,
          power_W: 0.5,
          position_m: (0.002 * k) / count,
        },
        now_ms - (1000 * (count - k)) / rate_Hz,
      );
    }
  }

  /** What the service `history` answers of the same strain, `seconds` long, up to now. */
  past(seconds, rate_Hz = 50) {
    const rows = Array.from({ length: seconds * rate_Hz }, (_, k) => k);
    const now_ms = Date.now();
    return {
      t_ns: rows.map((k) => Math.round((now_ms - (1000 * (rows.length - k)) / rate_Hz) * 1e3) * 1e3),
      strain: rows.map((k) => 0.04 - (0.02 * k) / rows.length),
      wire_temperature_K: rows.map((k) => 300 + (50 * k) / rows.length),
      drive_current_A: rows.map(() => 0.2),
    };
  }

  /** Samples from now on, until the next begin(). */
  stream() {
    this.streaming = setInterval(() => this.samples(0.1), 100);
  }

  /** In force at once. */
  now({ state = {}, bridge = {} }) {
    Object.assign(this.state, state);
    Object.assign(this.bridge, bridge);
    this.tell();
  }

  /** All connections end. */
  drop() {
    for (const socket of this.sockets.clients) {
      socket.terminate();
    }
  }

  close() {
    clearInterval(this.timer);
    clearInterval(this.streaming);
    this.drop();
    this.http.close();
  }
}

/** The page that a host-sim serves. */
async function page_of(bridge_url) {
  return Buffer.from(await (await fetch(bridge_url)).arrayBuffer());
}

module.exports = { ScriptedBridge, page_of };
