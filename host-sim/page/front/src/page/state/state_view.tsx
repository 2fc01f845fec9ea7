import { useEffect, useState } from 'preact/hooks';
import { hotSpotText, plain, shownAs } from '../../live/display';
import { formatNumber } from '../../numbers/format';
import { toShown } from '../../numbers/units';
import type { State } from '../../protocol/bridge';
import {
  act,
  bridge,
  call,
  client,
  description,
  hotSpotMargin_K,
  mayWrite,
  node,
  scan,
  state,
} from '../../session/session';
import { named } from '../../session/tuning';
import { units } from '../../session/units';
import { allowed, driveNames } from './drive';
import { Machine } from './machine';

export function StateView() {
  const now = state.value;
  return (
    <div class="two-columns">
      <section aria-label="State of the drive">
        <div class="card">
          <div class="card-head">
            <h2>Drive (CiA 402)</h2>
            <span class="soft">{now ? `${now.nmt}, statusword ${hex(now.statusword)}` : ''}</span>
          </div>
          <Machine now={now?.drive ?? null} />
          <Buttons now={now} />
        </div>
        {now && <Faults now={now} />}
        {now?.freeze_frame && <FreezeFrame values={now.freeze_frame} cause={now.first_cause} />}
      </section>
      <aside class="side" aria-label="Bus">
        {now && <Limits now={now} />}
        <Bus />
        <Clients />
      </aside>
    </div>
  );
}

function hex(word: number): string {
  return `${word.toString(16).toUpperCase().padStart(4, '0')}h`;
}

function Buttons({ now }: { now: State | null }) {
  const may = allowed(now);
  const commands = [
    {
      service: 'enable',
      title: 'Enable',
      allowed: may.enable,
      why: now?.blocking.length ? 'blocked, see below' : 'not in this state',
    },
    { service: 'disable', title: 'Disable', allowed: may.disable, why: 'nothing to switch off' },
    { service: 'reset_faults', title: 'Reset faults', allowed: may.reset, why: 'no fault to reset' },
  ];
  return (
    <div class="bar wrap">
      {commands.map((command) => (
        <button
          type="button"
          key={command.service}
          class="big"
          data-testid={`state-${command.service}`}
          disabled={!command.allowed || !mayWrite.value}
          title={command.allowed ? undefined : command.why}
          onClick={() => void act(command.service, { node: node.value })}>
          {command.title}
        </button>
      ))}
      <span class="soft" data-testid="drive-words">
        {now ? `Now: ${driveNames[now.drive]}.` : 'No state has been read.'}
      </span>
    </div>
  );
}

function Faults({ now }: { now: State }) {
  const latched = [...now.latched].sort((a, b) => Number(b === now.first_cause) - Number(a === now.first_cause));
  const blocking = now.blocking.filter((name) => !now.latched.includes(name));
  const active = [...new Set([...now.active, ...(now.warnings ?? [])])].filter(
    (name) => !now.latched.includes(name) && !now.blocking.includes(name),
  );
  return (
    <>
      <section class="card" data-testid="blocking">
        <h2>{now.blocking.length > 0 ? 'What blocks enabling' : 'Enabling'}</h2>
        {now.blocking.length === 0 && (
          <p class="good">
            {now.drive === 'operation_enabled' ? 'The servo is enabled.' : 'Nothing blocks: the servo can be enabled.'}
          </p>
        )}
        {blocking.map((name) => (
          <Fault key={name} name={name} tags={tagsOf(now, name)} open />
        ))}
        {blocking.length === 0 && now.blocking.length > 0 && (
          <p>The faults below. Remove their cause, then reset them.</p>
        )}
      </section>
      <section class="card" data-testid="faults">
        <h2>Faults</h2>
        {latched.length === 0 && <p class="good">No fault is latched.</p>}
        {latched.map((name) => (
          <Fault key={name} name={name} tags={tagsOf(now, name)} open={name === now.first_cause} />
        ))}
      </section>
      {active.length > 0 && (
        <section class="card" data-testid="warnings">
          <h2>Conditions present now or within the last second</h2>
          {active.map((name) => (
            <Fault key={name} name={name} tags={tagsOf(now, name)} />
          ))}
        </section>
      )}
    </>
  );
}

/** How often the cause of a warning has come; once is not worth a word. */
function timesText(times: number): string {
  return times > 1 ? `${times} times` : '';
}

function tagsOf(now: State, name: string): string[] {
  return [
    name === now.first_cause ? 'first cause' : '',
    // A warning stands for a second after its cause: the card says that it is there.
    now.warnings?.includes(name)
      ? timesText(now.warning_causes?.[name] ?? 0)
      : now.active.includes(name)
        ? 'present now'
        : now.latched.includes(name)
          ? 'gone, can be reset'
          : '',
  ].filter((tag) => tag !== '');
}

function Fault({ name, tags, open: openFirst = false }: { name: string; tags: string[]; open?: boolean }) {
  const [open, setOpen] = useState(openFirst);
  const [explained, setExplained] = useState<string | null>(null);
  useEffect(() => {
    if (!open || explained !== null) {
      return;
    }
    call('explain', { fault: name }).then(
      (answer) => setExplained(String(answer['text'])),
      (error: Error) => setExplained(`It could not be read: ${error.message}.`),
    );
  }, [open]);
  const info = description.value?.faults.find((fault) => fault.name === name);
  return (
    <article class="fault" data-testid={`fault-${name}`}>
      <button type="button" class="fault-head" aria-expanded={open} onClick={() => setOpen(!open)}>
        <span class="chevron" aria-hidden="true">
          {open ? '▾' : '▸'}
        </span>
        <strong>{name}</strong>
        {tags.map((tag) => (
          <span key={tag} class={`mark${tag === 'first cause' ? ' strong' : ''}`}>
            {tag}
          </span>
        ))}
        <span class="spring" />
        <span class="soft">
          {info?.code} {info?.class}
        </span>
      </button>
      {(!open || explained === null) && <p>{named(info?.text ?? '')}</p>}
      {open && explained !== null && <pre class="explained">{named(explained)}</pre>}
    </article>
  );
}

function FreezeFrame({ values, cause }: { values: Record<string, number | null>; cause: string | null }) {
  return (
    <section class="card" data-testid="freeze-frame">
      <h2>Freeze frame</h2>
      <p class="soft">The last values that were read before {cause || 'the first cause'} was seen.</p>
      <dl class="frame">
        {Object.entries(values).map(([name, value]) => {
          const shown = shownAs(name, units.value);
          return (
            <div key={name}>
              <dt title={name}>{plain(name)}</dt>
              <dd>
                {value === null ? '–' : formatNumber(toShown(shown, value))} <small>{shown.unit}</small>
              </dd>
            </div>
          );
        })}
      </dl>
      {'hot_spot_K' in values && <p class="soft small-text">{hotSpotText(hotSpotMargin_K.value)}</p>}
    </section>
  );
}

function Limits({ now }: { now: State }) {
  return (
    <section class="card" data-testid="limits">
      <h2>Limits that act</h2>
      {now.limits.length === 0 ? (
        <p class="soft">None.</p>
      ) : (
        <p>
          {now.limits.map((name) => (
            <span key={name} class="mark">
              {plain(name)}
            </span>
          ))}
        </p>
      )}
    </section>
  );
}

function Bus() {
  const now = bridge.value;
  const [scanning, setScanning] = useState(false);
  if (!now) {
    return null;
  }
  return (
    <section class="card" data-testid="bus">
      <div class="card-head">
        <h2>Bus</h2>
        <span class="soft">{now.bus}</span>
      </div>
      <table class="full">
        <thead>
          <tr>
            <th>Node</th>
            <th>Name</th>
            <th>State</th>
          </tr>
        </thead>
        <tbody>
          {now.nodes.map((info) => (
            <tr key={info.node}>
              <td>{info.node}</td>
              <td>{info.name}</td>
              <td>{info.duplicate ? 'node-id used twice' : info.online ? 'online' : 'does not answer'}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <button
        type="button"
        data-testid="scan"
        disabled={scanning}
        onClick={async () => {
          setScanning(true);
          await scan();
          setScanning(false);
        }}>
        {scanning ? 'Scanning …' : 'Scan'}
      </button>
    </section>
  );
}

function Clients() {
  const now = bridge.value;
  if (!now) {
    return null;
  }
  return (
    <section class="card" data-testid="clients">
      <h2>Browsers and tools</h2>
      <table class="full">
        <thead>
          <tr>
            <th>Client</th>
            <th>From</th>
            <th>Left out</th>
          </tr>
        </thead>
        <tbody>
          {now.clients.map((one) => (
            <tr key={one.client}>
              <td>
                {one.client}
                {one.client === client.value ? ', this one' : ''}
              </td>
              <td>
                {one.address}
                {one.read_only ? ', view only' : ''}
                {one.client === now.control ? ', in control' : ''}
              </td>
              <td>{one.dropped}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </section>
  );
}
