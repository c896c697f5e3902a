!> The mesh before it is used: no element is inverted.
module setup_jacobian
  use base_kinds, only: wp
  use base_error, only: error_t, place_t, fail, DECK_ERROR
  use base_text, only: to_text
  use mesh, only: mesh_t
  use rigid_block, only: is_rigid
  use setup_build, only: build_t
  use tensor, only: det3
  implicit none
  private
  public :: check_jacobians

contains

  !> Every element must be right-handed at all its integration points; one message a block.
  subroutine check_jacobians(build, mesh)
    type(build_t), intent(inout) :: build
    type(mesh_t), intent(in) :: mesh
    type(error_t), allocatable :: error
    type(place_t) :: place
    character(:), allocatable :: text, hint
    real(wp) :: least, worst
    integer :: b, e, first, bad

    do b = 1, size(mesh%block)
      if (is_rigid(mesh%block(b))) cycle
      bad = 0
      first = 0
      worst = 0.0_wp
      do e = 1, mesh%block(b)%nelem
        least = smallest_jacobian(mesh, b, e)
        if (least > 0.0_wp) cycle
        bad = bad + 1
        if (first == 0) then
          first = e
          worst = least
        end if
      end do
      if (bad == 0) cycle
      associate (block => mesh%block(b))
        text = 'element '//to_text(block%number(first))//' is inverted: its Jacobian is ' &
               //to_text(worst)
        if (bad > 1) text = text//', and '//to_text(bad - 1)//' more are'
        hint = 'the first four nodes go counter-clockwise seen from the other four'
        if (block%body > 0) then
          place = mesh%body(block%body)%place
          hint = 'more elements follow the shape more closely; or enrich other faces'
        else
          place = build%places%at(build%elements%place(block%number(first)))
        end if
      end associate
      call fail(error, DECK_ERROR, text, place, hint)
      call build%errors%add(error)
    end do
  end subroutine check_jacobians

  pure real(wp) function smallest_jacobian(mesh, b, e) result(least)
    type(mesh_t), intent(in) :: mesh
    integer, intent(in) :: b, e
    real(wp) :: x(3, mesh%block(b)%nen)
    integer :: q

    least = huge(least)
    associate (block => mesh%block(b))
      x = mesh%xr(:, block%conn(:, e))
      associate (basis => block%basis(block%ibasis(e)))
        do q = 1, basis%nq
          least = min(least, det3(matmul(x, transpose(basis%dshp(:, :, q)))))
        end do
      end associate
    end associate
    if (.not. least < huge(least)) least = 0.0_wp
  end function smallest_jacobian

end module setup_jacobian
