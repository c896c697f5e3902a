!> Q1E9N and Q1E9NT: the enriched element Q1Np.t with nine enhanced modes.
!!
!! The modes are the covectors (xi,0,0), (0,eta,0), (0,0,zeta) of Q1E9 on the enriched hexahedron,
!! with J0 and j0 at its centre. In the tapered element, the first two modes are multiplied by (1 +
!! zeta)/2, so that they vanish on the enriched face.
!!
!! Nodes, functions: as Q1N
!! Rule:    (p+1) x (p+1) x 2; collapsed prisms need 3 points in zeta
!! History: nine parameters, then m and L (element_form_i)
!! Source:  modes of Simo and Armero 1992; the element is new in this program
module elmt_q1e9n2
  use base_kinds, only: wp
  use element_type, only: element_t
  use elmt_q1n2, only: set_rule, functions, set_topology
  use hexa_shape, only: nine_modes
  use solid_form, only: form
  implicit none
  private
  public :: describe, describe_tapered

contains

  !> Row of this element in the table of elements.
  function describe() result(row)
    type(element_t) :: row

    row = element_t(name='Q1E9N', &
                    source='linear bulk, isogeometric surface, nine enhanced modes', &
                    spline=.true., nmode=3, rule=set_rule, functions=functions, &
                    topology=set_topology, modes=nine_modes, form=form)
  end function describe

  !> Row of the tapered element in the table of elements.
  function describe_tapered() result(row)
    type(element_t) :: row

    row = describe()
    row%name = 'Q1E9NT'
    row%source = 'linear bulk, isogeometric surface, nine enhanced modes tapered towards the ' &
                 //'surface'
    row%modes => tapered_modes
  end function describe_tapered

  !> Evaluate the modes, and multiply the two in-plane modes by (1 + zeta)/2.
  pure subroutine tapered_modes(xi, mode)
    real(wp), intent(in) :: xi(3)
    real(wp), intent(out) :: mode(:, :) !! (3, 3)

    call nine_modes(xi, mode)
    mode(:, :2) = mode(:, :2)*(0.5_wp*(1.0_wp + xi(3)))
  end subroutine tapered_modes

end module elmt_q1e9n2
