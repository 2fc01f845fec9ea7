import { useEffect } from 'preact/hooks';
import { at } from '../session/route';
import { bridge, link, lostReason, nodes, state } from '../session/session';
import { ChooseView } from './choose/choose_view';
import { GuideView } from './guide/guide_view';
import { Header, narrow, UnitsChoice } from './header';
import { LiveView } from './live/live_view';
import { NoticeList } from './notice_list';
import { ParameterView } from './parameters/parameter_view';
import { StateView } from './state/state_view';
import { StepView } from './step/step_view';

const views = [
  { id: 'live', title: 'Live', view: LiveView },
  { id: 'parameters', title: 'Parameters', view: ParameterView },
  { id: 'step', title: 'Step test', view: StepView },
  { id: 'state', title: 'State', view: StateView },
  { id: 'guide', title: 'First run', view: GuideView },
  { id: 'choose', title: 'Choose a wire', view: ChooseView },
] as const;

export function App() {
  useEffect(() => {
    const changed = (): void => {
      at.value = location.hash.slice(1);
      scrollTo(0, 0);
    };
    addEventListener('hashchange', changed);
    return () => removeEventListener('hashchange', changed);
  }, []);
  const current = views.find((view) => view.id === at.value) ?? views[0];
  const faults = state.value?.latched.length ?? 0;
  return (
    <>
      <div class="top">
        <Header />
        <nav class="tabs" aria-label="Views">
          {views.map((view) => (
            <a
              key={view.id}
              href={`#${view.id}`}
              data-testid={`tab-${view.id}`}
              aria-current={view === current ? 'page' : undefined}>
              {view.title}
              {view.id === 'state' && faults > 0 && (
                <span class="badge" role="img" aria-label={`${faults} faults`}>
                  {faults}
                </span>
              )}
            </a>
          ))}
        </nav>
        <Trouble />
      </div>
      <main id="main">
        {narrow.value && (
          <div class="bar units-row">
            <span class="soft">Units</span>
            <UnitsChoice />
          </div>
        )}
        <current.view />
      </main>
      <NoticeList />
    </>
  );
}

/** What makes the page less than it looks: said large, above everything. */
function Trouble() {
  if (link.value === 'lost') {
    return (
      <div class="trouble" role="alert" data-testid="lost">
        <strong>No connection to the bridge.</strong> What is shown is not live. The servos go off by themselves when
        nobody commands them. Trying again …{lostReason.value && <span class="soft"> ({lostReason.value})</span>}
      </div>
    );
  }
  if (link.value === 'connecting') {
    return (
      <div class="trouble calm" role="status">
        Connecting to the bridge …
      </div>
    );
  }
  const twice = nodes.value.filter((info) => info.duplicate);
  return (
    <>
      {bridge.value?.trouble && (
        <div class="trouble" role="alert" data-testid="bus-trouble">
          {/^this computer/.test(bridge.value.trouble) ? null : <strong>Bus: </strong>}
          {bridge.value.trouble}
        </div>
      )}
      {twice.map((info) => (
        <div class="trouble" role="alert" key={info.node} data-testid="duplicate">
          <strong>Two devices have the node-id {info.node}.</strong> Neither is commanded. Switch one off, or give it
          another node-id.
        </div>
      ))}
      {state.value && !state.value.online && (
        <div class="trouble" role="alert" data-testid="offline">
          <strong>Servo {state.value.node} does not answer.</strong> Its last values are shown.
        </div>
      )}
      {bridge.value && nodes.value.length === 0 && (
        <div class="trouble calm" role="status" data-testid="no-servo">
          No servo on {bridge.value.bus} yet. One appears here as soon as it answers.
        </div>
      )}
    </>
  );
}
