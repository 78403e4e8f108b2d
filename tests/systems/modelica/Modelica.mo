within ;
package Modelica "What the package EvatSystems uses of the Modelica Standard Library, and no more"
  package Units
    package SI
      type Distance = Real(final unit = "m");
      type Length = Real(final unit = "m");
      type Position = Real(final unit = "m");
      type Velocity = Real(final unit = "m/s");
      type Mass = Real(final unit = "kg");
      type Force = Real(final unit = "N");
      type TranslationalSpringConstant = Real(final unit = "N/m");
      type Angle = Real(final unit = "rad");
      type Torque = Real(final unit = "N.m");
      type Temperature = Real(final unit = "K");
      type HeatFlowRate = Real(final unit = "W");
    end SI;
  end Units;
  package Blocks
    package Interfaces
      connector RealInput = input Real;
      connector RealOutput = output Real;
    end Interfaces;
  end Blocks;
  package Mechanics
    package Translational
      package Interfaces
        connector Flange_a
          Modelica.Units.SI.Position s;
          flow Modelica.Units.SI.Force f;
        end Flange_a;
        connector Flange_b
          Modelica.Units.SI.Position s;
          flow Modelica.Units.SI.Force f;
        end Flange_b;
        partial model PartialTwoFlanges
          Flange_a flange_a;
          Flange_b flange_b;
        end PartialTwoFlanges;
      end Interfaces;
      package Components
        model Fixed
          Modelica.Mechanics.Translational.Interfaces.Flange_b flange;
        equation
          flange.s = 0;
        end Fixed;
        model Mass
          extends Modelica.Mechanics.Translational.Interfaces.PartialTwoFlanges;
          parameter Modelica.Units.SI.Mass m = 1;
          Modelica.Units.SI.Position s;
          Modelica.Units.SI.Velocity v;
        equation
          flange_a.s = s;
          flange_b.s = s;
          v = der(s);
          m * der(v) = flange_a.f + flange_b.f;
        end Mass;
        model Spring
          extends Modelica.Mechanics.Translational.Interfaces.PartialTwoFlanges;
          parameter Modelica.Units.SI.TranslationalSpringConstant c = 1;
          Modelica.Units.SI.Force f;
        equation
          f = c * (flange_b.s - flange_a.s);
          flange_b.f = f;
          flange_a.f = -f;
        end Spring;
      end Components;
      package Sources
        model ConstantSpeed
          parameter Modelica.Units.SI.Velocity v_fixed = 1;
          Modelica.Mechanics.Translational.Interfaces.Flange_b flange;
          Modelica.Units.SI.Position s(start = 0, fixed = true);
        equation
          s = flange.s;
          der(s) = v_fixed;
        end ConstantSpeed;
      end Sources;
    end Translational;
    package Rotational
      package Interfaces
        connector Flange_a
          Modelica.Units.SI.Angle phi;
          flow Modelica.Units.SI.Torque tau;
        end Flange_a;
      end Interfaces;
    end Rotational;
  end Mechanics;
  package Thermal
    package HeatTransfer
      package Interfaces
        connector HeatPort_a
          Modelica.Units.SI.Temperature T;
          flow Modelica.Units.SI.HeatFlowRate Q_flow;
        end HeatPort_a;
      end Interfaces;
    end HeatTransfer;
  end Thermal;
end Modelica;
